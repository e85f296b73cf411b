# egofocus_optional_library(NAME header names): target egofocus_NAME when header and library are found, else none.
# Looked up by hand: HDF5's own find module runs its compiler wrapper, which in a cross build is the host's.
function(egofocus_optional_library name header libraries)
  if(TARGET egofocus_${name})
    return()
  endif()
  string(REPLACE "," ";" candidates ${libraries})
  find_path(EGOFOCUS_${name}_INCLUDE_DIR NAMES ${header} PATH_SUFFIXES hdf5/serial libusb-1.0)
  find_library(EGOFOCUS_${name}_LIBRARY NAMES ${candidates})
  mark_as_advanced(EGOFOCUS_${name}_INCLUDE_DIR EGOFOCUS_${name}_LIBRARY)
  if(EGOFOCUS_${name}_INCLUDE_DIR AND EGOFOCUS_${name}_LIBRARY)
    add_library(egofocus_${name} INTERFACE)
    target_link_libraries(egofocus_${name} INTERFACE ${EGOFOCUS_${name}_LIBRARY})
    if(NOT EGOFOCUS_${name}_INCLUDE_DIR STREQUAL "/usr/include")
      target_include_directories(egofocus_${name} SYSTEM INTERFACE ${EGOFOCUS_${name}_INCLUDE_DIR})
    endif()
  endif()
endfunction()

# The packets of AEDAT4: the recording library and a fuzzer need them.
egofocus_optional_library(LZ4 lz4frame.h lz4)
egofocus_optional_library(ZSTD zstd.h zstd)
# Cameras on USB.
egofocus_optional_library(USB libusb.h usb-1.0)
