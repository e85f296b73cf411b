// HDF5 files, read in pieces: a thin layer over the C library that checks what a file says before it is used.
// Everything throws Error: kFile (missing, unreadable, or this build has no HDF5; the message has the line
// that installs it), kBadFile (truncated, a data set that is missing or of another rank or type).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace egofocus::recording {

enum class Hdf5Type : std::uint8_t { kInteger, kFloat };

/// An open data set. Move-only; must not outlive its file.
class Hdf5Dataset {
 public:
  Hdf5Dataset(Hdf5Dataset&& other) noexcept;
  Hdf5Dataset(const Hdf5Dataset&) = delete;
  Hdf5Dataset& operator=(const Hdf5Dataset&) = delete;
  Hdf5Dataset& operator=(Hdf5Dataset&&) = delete;
  ~Hdf5Dataset();

  [[nodiscard]] const std::vector<std::uint64_t>& dims() const { return dims_; }
  [[nodiscard]] std::uint64_t rows() const { return dims_.empty() ? 1 : dims_[0]; }
  /// Values of one row: the product of all dimensions but the first.
  [[nodiscard]] std::size_t row_values() const { return row_values_; }

  /// Rows [first, first + count), converted by the library; `out` must hold count * row_values() values.
  void read(std::uint64_t first, std::size_t count, std::span<double> out) const;
  void read(std::uint64_t first, std::size_t count, std::span<float> out) const;
  void read(std::uint64_t first, std::size_t count, std::span<std::int64_t> out) const;

  /// "FILE:/name"
  [[nodiscard]] const std::string& where() const { return where_; }

 private:
  friend class Hdf5File;
  Hdf5Dataset(std::int64_t id, std::string where);
  void check_type(Hdf5Type type) const;
  void check_filters() const;
  void read_rows(std::uint64_t first, std::size_t count, std::int64_t memory_type, void* out,
                 std::size_t room) const;

  [[maybe_unused]] std::int64_t id_ = -1;
  std::string where_;
  std::vector<std::uint64_t> dims_;
  std::size_t row_values_ = 1;
};

class Hdf5File {
 public:
  explicit Hdf5File(std::filesystem::path path);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  /// Is there anything of this name, such as "/davis/left/imu"?
  [[nodiscard]] bool has(const std::string& name) const;

  /// `rank` 0 is a scalar. All filters must be there, and a data set with rows must have data.
  [[nodiscard]] Hdf5Dataset dataset(const std::string& name, std::size_t rank, Hdf5Type type) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  [[maybe_unused]] std::int64_t id_ = -1;
};

/// Does the file begin as HDF5 files do? False when it cannot be read.
[[nodiscard]] bool is_hdf5(const std::filesystem::path& path);

}  // namespace egofocus::recording
