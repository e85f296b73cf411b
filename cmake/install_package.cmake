# The install tree: headers, library, CMake package (find_package(egofocus) -> egofocus::egofocus) and egofocus.pc.
# Nothing in it names the place where it was built or installed: the tree may be moved.
include(CMakePackageConfigHelpers)

set(EGOFOCUS_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/egofocus)

install(TARGETS egofocus EXPORT egofocus_targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/egofocus ${PROJECT_BINARY_DIR}/generated/egofocus
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h")
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT egofocus_targets NAMESPACE egofocus:: FILE egofocus_targets.cmake DESTINATION ${EGOFOCUS_CMAKE_DIR})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/egofocus-config.cmake.in
                              ${PROJECT_BINARY_DIR}/egofocus-config.cmake INSTALL_DESTINATION ${EGOFOCUS_CMAKE_DIR})
# While the major version is 0, a new minor version may change the API: 0.1 does not answer a wish for 0.2, nor the
# other way round.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/egofocus-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/egofocus-config.cmake ${PROJECT_BINARY_DIR}/egofocus-config-version.cmake
        DESTINATION ${EGOFOCUS_CMAKE_DIR})

# From the .pc file's folder up to the prefix; an absolute libdir stays as it is.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
  set(EGOFOCUS_PC_PREFIX ${CMAKE_INSTALL_PREFIX})
else()
  file(RELATIVE_PATH EGOFOCUS_PC_UP /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" EGOFOCUS_PC_UP ${EGOFOCUS_PC_UP})
  set(EGOFOCUS_PC_PREFIX "\${pcfiledir}/${EGOFOCUS_PC_UP}")
endif()
set(EGOFOCUS_PC_USB "")
if(EGOFOCUS_USB AND TARGET egofocus_USB)
  set(EGOFOCUS_PC_USB " -lusb-1.0")
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/egofocus.pc.in ${PROJECT_BINARY_DIR}/egofocus.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/egofocus.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# The command line goes along when it was built, and what lets it open cameras.
if(TARGET egofocus_app)
  install(FILES ${PROJECT_SOURCE_DIR}/apps/egofocus/70-egofocus.rules DESTINATION lib/udev/rules.d)
  install(TARGETS egofocus_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
