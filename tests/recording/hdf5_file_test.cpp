#include "recording/hdf5_file.hpp"

#include <catch2/catch.hpp>

#include "recording/error.hpp"
#include "recording/hdf5_writer.hpp"
#include "recording/temporary_folder.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using namespace egofocus::test;
using Catch::Matchers::Contains;

TEST_CASE("rows are read in pieces and in any number type") {
  const TemporaryFolder at;
  {
    Hdf5Writer writer(at / "a.h5");
    writer.write("/g/rows", H5T_IEEE_F32LE, {3, 2}, std::vector<double>{0.5, 1.5, 2.5, 3.5, 4.5, 5.5});
    writer.write("/g/whole", H5T_STD_U16BE, {2}, std::vector<std::int64_t>{65535, 7});
    writer.write("/scalar", H5T_STD_I64LE, {}, std::vector<std::int64_t>{-5});
  }
  const Hdf5File file(at / "a.h5");
  CHECK(file.has("/g/rows"));
  CHECK_FALSE(file.has("/h/rows"));
  CHECK_FALSE(file.has("/g/rows/deeper"));
  const Hdf5Dataset rows = file.dataset("/g/rows", 2, Hdf5Type::kFloat);
  CHECK(rows.rows() == 3);
  CHECK(rows.row_values() == 2);
  std::vector<double> values(4);
  rows.read(1, 2, values);
  CHECK(values == std::vector<double>{2.5, 3.5, 4.5, 5.5});
  CHECK_THROWS_WITH(rows.read(2, 2, values), Contains("rows beyond the data set"));
  CHECK_THROWS_WITH(rows.read(0, 3, values), Contains("rows beyond the data set"));
  std::vector<std::int64_t> whole(2);
  file.dataset("/g/whole", 1, Hdf5Type::kInteger).read(0, 2, whole);
  CHECK(whole == std::vector<std::int64_t>{65535, 7});
  file.dataset("/scalar", 0, Hdf5Type::kInteger).read(0, 1, std::span(whole));
  CHECK(whole[0] == -5);
  CHECK_THROWS_WITH(file.dataset("/g", 1, Hdf5Type::kFloat), Contains("is no data set"));
}

TEST_CASE("a size far beyond the data is refused, not read as zeros") {
  const TemporaryFolder at;
  {
    const hid_t file = H5Fcreate((at / "a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk = 1000;
    const hsize_t size = hsize_t{1} << 50;
    H5Pset_chunk(properties, 1, &chunk);
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    const hid_t set = H5Dcreate2(file, "t", H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    const hsize_t first = 0;
    H5Sselect_hyperslab(space, H5S_SELECT_SET, &first, nullptr, &chunk, nullptr);
    const hid_t memory = H5Screate_simple(1, &chunk, nullptr);
    const std::vector<double> values(chunk, 1.0);
    REQUIRE(H5Dwrite(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()) >= 0);
    for (const hid_t opened : {space, memory}) H5Sclose(opened);
    H5Dclose(set);
    H5Pclose(properties);
    H5Fclose(file);
  }
  const Hdf5File file(at / "a.h5");
  CHECK_THROWS_WITH(file.dataset("/t", 1, Hdf5Type::kFloat), Contains("1125899906842624 rows, but no data"));
}
