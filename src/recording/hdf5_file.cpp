#include "recording/hdf5_file.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>

#include "recording/error.hpp"
#include "recording/lzf.hpp"

#ifdef EGOFOCUS_HAVE_HDF5
#include <hdf5.h>
#endif

namespace egofocus::recording {

bool is_hdf5(const std::filesystem::path& path) {
  static constexpr std::array<char, 8> kSignature{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  std::array<char, 8> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  return file && head == kSignature;
}

namespace {

void require_hdf5(const std::filesystem::path& path) {
  if (!std::ifstream(path, std::ios::binary))
    throw Error(ExitCode::kFile, path.string(), "cannot be opened. Check the path and the permissions.");
  if (!is_hdf5(path)) throw Error(ExitCode::kBadFile, path.string(), "is no HDF5 file.");
}

}  // namespace

#ifdef EGOFOCUS_HAVE_HDF5

namespace {

constexpr std::uint64_t kMostRowValues = 1u << 26;  // one row in memory: at most 512 MiB

/// Closes an id of the library with its own function.
struct Id {
  hid_t value;
  herr_t (*close)(hid_t);
  Id(hid_t id, herr_t (*closer)(hid_t)) : value(id), close(closer) {}
  ~Id() {
    if (value >= 0) close(value);
  }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
};

struct Filter {
  H5Z_filter_t id;
  const char* name;
  const char* package;  // of Debian
};
constexpr Filter kFilters[] = {
    {32000, "LZF", "hdf5-plugin-lzf"},           {32001, "Blosc", "hdf5-filter-plugin-blosc-serial"},
    {307, "bzip2", "hdf5-filter-plugin"},        {32004, "LZ4", "hdf5-filter-plugin"},
    {32008, "bitshuffle", "hdf5-filter-plugin"}, {32013, "ZFP", "hdf5-filter-plugin-zfp-serial"}};

constexpr H5Z_filter_t kLzf = 32000;

/// The library's own signature: `*buffer` holds `bytes` packed bytes, and is replaced. 0: damaged.
std::size_t lzf_filter(unsigned flags, std::size_t value_count, const unsigned values[], std::size_t bytes,
                       std::size_t* buffer_bytes, void** buffer) {
  // h5py's third value is the size of a chunk.
  const std::size_t room = value_count >= 3 ? values[2] : 0;
  if ((flags & H5Z_FLAG_REVERSE) == 0 || room == 0 || room > kMostRowValues * sizeof(double)) return 0;
  void* const unpacked = H5allocate_memory(room, false);
  if (!unpacked) return 0;
  const std::optional<std::size_t> size = unpack_lzf({static_cast<const std::uint8_t*>(*buffer), bytes},
                                                     {static_cast<std::uint8_t*>(unpacked), room});
  if (!size || *size == 0) {
    H5free_memory(unpacked);
    return 0;
  }
  H5free_memory(*buffer);
  *buffer = unpacked;
  *buffer_bytes = room;
  return *size;
}

/// Errors are ours to report, not printed by the library; LZF is read wherever no plugin does.
void set_up_library() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  static constexpr H5Z_class2_t kClass{H5Z_CLASS_T_VERS, kLzf, 0, 1, "lzf", nullptr, nullptr, lzf_filter};
  if (H5Zfilter_avail(kLzf) <= 0) H5Zregister(&kClass);
}

}  // namespace

Hdf5Dataset::Hdf5Dataset(std::int64_t id, std::string where) : id_(id), where_(std::move(where)) {}

Hdf5Dataset::Hdf5Dataset(Hdf5Dataset&& other) noexcept
    : id_(std::exchange(other.id_, -1)),
      where_(std::move(other.where_)),
      dims_(std::move(other.dims_)),
      row_values_(other.row_values_) {}

Hdf5Dataset::~Hdf5Dataset() {
  if (id_ >= 0) H5Dclose(id_);
}

void Hdf5Dataset::check_type(Hdf5Type type) const {
  const Id stored(H5Dget_type(id_), H5Tclose);
  const H5T_class_t wanted = type == Hdf5Type::kFloat ? H5T_FLOAT : H5T_INTEGER;
  // h5py stores bool as an enumeration of integers.
  const H5T_class_t found = H5Tget_class(stored.value);
  if (found == wanted || (wanted == H5T_INTEGER && found == H5T_ENUM)) return;
  throw Error(ExitCode::kBadFile, where_,
              std::string("has the wrong type: ") + (type == Hdf5Type::kFloat ? "floats" : "integers") +
                  " are needed. Is it the original file?");
}

void Hdf5Dataset::check_filters() const {
  const Id properties(H5Dget_create_plist(id_), H5Pclose);
  const int count = H5Pget_nfilters(properties.value);
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter = H5Pget_filter2(properties.value, static_cast<unsigned>(i), &flags, &values,
                                               nullptr, 0, nullptr, nullptr);
    if (filter < 0 || H5Zfilter_avail(filter) > 0) continue;
    for (const Filter& known : kFilters) {
      if (known.id != filter) continue;
      throw Error(ExitCode::kFile, where_,
                  std::string("is compressed with ") + known.name +
                      ", and HDF5's plugin for it is missing. "
                      "Debian: apt-get install " +
                      known.package);
    }
    throw Error(ExitCode::kFile, where_,
                "is compressed with HDF5 filter " + std::to_string(filter) +
                    ", whose plugin is missing. Install it, or store the file without it (h5repack).");
  }
}

void Hdf5Dataset::read_rows(std::uint64_t first, std::size_t count, std::int64_t memory_type, void* out,
                            std::size_t room) const {
  if (room < count * row_values_ || first > rows() || count > rows() - first)
    throw Error(ExitCode::kInternal, where_, "rows beyond the data set are asked for.");
  if (count == 0) return;
  const Id file_space(H5Dget_space(id_), H5Sclose);
  std::vector<hsize_t> start(dims_.size(), 0);
  std::vector<hsize_t> extent(dims_.begin(), dims_.end());
  herr_t status = 0;
  if (!dims_.empty()) {
    start[0] = first;
    extent[0] = count;
    status =
        H5Sselect_hyperslab(file_space.value, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr);
  }
  const hsize_t values = count * row_values_;
  const Id memory_space(H5Screate_simple(1, &values, nullptr), H5Sclose);
  if (status >= 0) status = H5Dread(id_, memory_type, memory_space.value, file_space.value, H5P_DEFAULT, out);
  if (status < 0) {
    throw Error(ExitCode::kBadFile, where_,
                "cannot be read at row " + std::to_string(first) +
                    ": the file is truncated or damaged. Copy or download it again.");
  }
}

void Hdf5Dataset::read(std::uint64_t first, std::size_t count, std::span<double> out) const {
  read_rows(first, count, H5T_NATIVE_DOUBLE, out.data(), out.size());
}
void Hdf5Dataset::read(std::uint64_t first, std::size_t count, std::span<float> out) const {
  read_rows(first, count, H5T_NATIVE_FLOAT, out.data(), out.size());
}
void Hdf5Dataset::read(std::uint64_t first, std::size_t count, std::span<std::int64_t> out) const {
  read_rows(first, count, H5T_NATIVE_INT64, out.data(), out.size());
}

Hdf5File::Hdf5File(std::filesystem::path path) : path_(std::move(path)) {
  set_up_library();
  require_hdf5(path_);
  id_ = H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id_ < 0) {
    throw Error(
        ExitCode::kBadFile, path_.string(),
        "is an HDF5 file that cannot be opened: truncated, or still being written. Copy or download it "
        "again.");
  }
}

Hdf5File::~Hdf5File() {
  if (id_ >= 0) H5Fclose(id_);
}

bool Hdf5File::has(const std::string& name) const {
  // Every group on the way must be there before the next one may be asked for.
  for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
    if (H5Lexists(id_, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

Hdf5Dataset Hdf5File::dataset(const std::string& name, std::size_t rank, Hdf5Type type) const {
  const std::string where = path_.string() + ":" + name;
  if (!has(name))
    throw Error(ExitCode::kBadFile, where, "is not in the file. Is it the right file, and whole?");
  Hdf5Dataset set(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), where);
  if (set.id_ < 0) throw Error(ExitCode::kBadFile, where, "is no data set.");
  set.check_type(type);
  const Id space(H5Dget_space(set.id_), H5Sclose);
  const int found = H5Sget_simple_extent_ndims(space.value);
  if (found != static_cast<int>(rank)) {
    throw Error(ExitCode::kBadFile, where,
                "has " + std::to_string(found) + " dimensions; " + std::to_string(rank) + " are needed.");
  }
  std::vector<hsize_t> dims(rank);
  if (rank > 0) H5Sget_simple_extent_dims(space.value, dims.data(), nullptr);
  set.dims_.assign(dims.begin(), dims.end());
  std::uint64_t values = 1;
  for (std::size_t i = 1; i < rank; ++i) {
    if (dims[i] == 0 || dims[i] > kMostRowValues / values)
      throw Error(ExitCode::kBadFile, where, "has rows of a size that cannot be.");
    values *= dims[i];
  }
  set.row_values_ = static_cast<std::size_t>(values);
  // Rows that nobody wrote values for would read as zeros. No filter packs real values this small.
  const auto stored = static_cast<double>(H5Dget_storage_size(set.id_));
  if (static_cast<double>(set.rows()) * static_cast<double>(values) > 1e5 * stored) {
    throw Error(ExitCode::kBadFile, where,
                "has " + std::to_string(set.rows()) +
                    " rows, but no data was ever written for them. Is the file whole?");
  }
  set.check_filters();
  return set;
}

#else

namespace {

[[noreturn]] void no_hdf5(const std::filesystem::path& path) {
  throw Error(ExitCode::kFile, path.string(),
              "HDF5 files need libhdf5, and this build has none. Debian: apt-get install libhdf5-dev, then "
              "build again.");
}

}  // namespace

Hdf5Dataset::Hdf5Dataset(Hdf5Dataset&& other) noexcept
    : id_(other.id_),
      where_(std::move(other.where_)),
      dims_(std::move(other.dims_)),
      row_values_(other.row_values_) {}
Hdf5Dataset::~Hdf5Dataset() = default;
void Hdf5Dataset::read(std::uint64_t, std::size_t, std::span<double>) const {
  no_hdf5(where_);
}
void Hdf5Dataset::read(std::uint64_t, std::size_t, std::span<float>) const {
  no_hdf5(where_);
}
void Hdf5Dataset::read(std::uint64_t, std::size_t, std::span<std::int64_t>) const {
  no_hdf5(where_);
}
Hdf5File::Hdf5File(std::filesystem::path path) : path_(std::move(path)) {
  require_hdf5(path_);
  no_hdf5(path_);
}
Hdf5File::~Hdf5File() = default;
bool Hdf5File::has(const std::string&) const {
  return false;
}
Hdf5Dataset Hdf5File::dataset(const std::string&, std::size_t, Hdf5Type) const {
  no_hdf5(path_);
}

#endif

}  // namespace egofocus::recording
