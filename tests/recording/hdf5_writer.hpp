// Writes HDF5 files for the tests, through the C library alone.
#pragma once

#include <dlfcn.h>
#include <hdf5.h>

#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace egofocus::test {

inline constexpr H5Z_filter_t kLzf = 32000;
inline constexpr H5Z_filter_t kBlosc = 32001;

class Hdf5Writer {
 public:
  explicit Hdf5Writer(const std::filesystem::path& path)
      : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {
    check(file_);
  }
  ~Hdf5Writer() { H5Fclose(file_); }
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  /// Groups on the way are made. `filter` 0: contiguous, else chunks of `chunk` rows with that filter.
  template <typename T>
  void write(const std::string& name, hid_t stored, const std::vector<hsize_t>& dims,
             const std::vector<T>& values, H5Z_filter_t filter = 0, hsize_t chunk = 1) {
    const hid_t links = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(links, 1);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    if (filter != 0) {
      std::vector<hsize_t> chunks = dims;
      chunks[0] = chunk;
      H5Pset_chunk(properties, static_cast<int>(chunks.size()), chunks.data());
      // Blosc: four reserved values, level 5, shuffle, codec 5 (Zstandard), as DSEC has it.
      const unsigned blosc[7] = {0, 0, 0, 0, 5, 1, 5};
      // LZF as h5py has it: revision, library version, bytes of a chunk.
      unsigned lzf[3] = {4, 0x0105, static_cast<unsigned>(H5Tget_size(stored))};
      for (const hsize_t side : chunks) lzf[2] *= static_cast<unsigned>(side);
      check(H5Pset_filter(properties, filter, H5Z_FLAG_MANDATORY,
                          filter == kBlosc ? 7
                          : filter == kLzf ? 3
                                           : 0,
                          filter == kBlosc ? blosc : lzf));
    }
    const hid_t space = dims.empty() ? H5Screate(H5S_SCALAR)
                                     : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr);
    const hid_t set = H5Dcreate2(file_, name.c_str(), stored, space, links, properties, H5P_DEFAULT);
    check(set);
    if (!values.empty()) check(H5Dwrite(set, native<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
    H5Dclose(set);
    H5Sclose(space);
    H5Pclose(properties);
    H5Pclose(links);
  }

 private:
  static void check(std::int64_t status) {
    if (status < 0) throw std::runtime_error("the test cannot write its HDF5 file");
  }
  template <typename T>
  static hid_t native() {
    if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
    if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
    if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  }

  hid_t file_;
};

/// Makes LZF writable as long as it lives: runs of equal bytes become copies, all else literals.
class LzfEncoder {
 public:
  LzfEncoder() {
    H5Zunregister(kLzf);
    static constexpr H5Z_class2_t kClass{H5Z_CLASS_T_VERS, kLzf, 1, 0, "lzf", nullptr, nullptr, encode};
    if (H5Zregister(&kClass) < 0) throw std::runtime_error("the test cannot register a filter");
  }
  ~LzfEncoder() { H5Zunregister(kLzf); }
  LzfEncoder(const LzfEncoder&) = delete;
  LzfEncoder& operator=(const LzfEncoder&) = delete;

  static std::vector<unsigned char> pack(const unsigned char* bytes, std::size_t count) {
    std::vector<unsigned char> packed;
    for (std::size_t i = 0; i < count;) {
      // How often the four bytes before repeat themselves from here on.
      std::size_t run = 0;
      while (i >= 4 && i + run < count && run < 264 && bytes[i + run] == bytes[i + run - 4]) ++run;
      if (run >= 9) {
        packed.insert(packed.end(), {0xe0, static_cast<unsigned char>(run - 9), 3});
      } else if (run >= 3) {
        packed.insert(packed.end(), {static_cast<unsigned char>((run - 2) << 5), 3});
      } else {
        run = 1;
        packed.insert(packed.end(), {0, bytes[i]});
      }
      i += run;
    }
    return packed;
  }

 private:
  static std::size_t encode(unsigned, std::size_t, const unsigned*, std::size_t bytes, std::size_t* room,
                            void** buffer) {
    const std::vector<unsigned char> packed = pack(static_cast<const unsigned char*>(*buffer), bytes);
    if (packed.size() > *room) {
      H5free_memory(*buffer);
      *buffer = H5allocate_memory(packed.size(), false);
      *room = packed.size();
    }
    std::memcpy(*buffer, packed.data(), packed.size());
    return packed.size();
  }
};

inline bool filter_available(H5Z_filter_t filter) {
  // Blosc never frees its context, and HDF5 unloads it at the end: a leak, unless it stays loaded.
  if (filter == kBlosc) (void)dlopen("libblosc.so.1", RTLD_NOW | RTLD_NODELETE);
  return H5Zfilter_avail(filter) > 0;
}

}  // namespace egofocus::test
