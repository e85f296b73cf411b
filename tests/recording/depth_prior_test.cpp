#include "recording/depth_prior.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "recording/error.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using Catch::Matchers::Contains;

namespace {

Picture<float> picture(std::int32_t width, std::vector<float> values) {
  Picture<float> out(width, static_cast<std::int32_t>(values.size()) / width);
  out.pixels = std::move(values);
  return out;
}

std::string complaint(const std::filesystem::path& path) {
  try {
    (void)read_prior(path);
  } catch (const Error& error) {
    CHECK(error.exit_code() == static_cast<int>(ExitCode::kBadFile));
    return error.what();
  }
  return "no complaint";
}

}  // namespace

TEST_CASE("a prior is the median and the harmonic mean of each row") {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  DepthPriorFit fit;
  fit.add(picture(2, {0, kFar, 2, 4, 90, 0, 0, 0}), {});
  fit.add(picture(2, {0, 0, 4, 0, 5, 5, 0, 0}), {});
  const DepthPrior prior = fit.result();
  CHECK(prior.images == 2);
  CHECK(prior.median_m == 4.0);  // of 2 4 4 5 5; 90 m and infinity are beyond the cut
  REQUIRE(prior.row_depth_m.size() == 4);
  CHECK(prior.row_depth_m[1] == Approx(3.0));  // 3 / (1/2 + 1/4 + 1/4)
  CHECK(prior.row_depth_m[2] == Approx(5.0));
  CHECK(prior.row_depth_m[0] == prior.row_depth_m[1]);  // no truth: the nearest row
  CHECK(prior.row_depth_m[3] == prior.row_depth_m[2]);

  TruthMedian median;
  CHECK(median.median_m() == 0);
  median.add(picture(1, {1, 2, 3, 4}), {});
  CHECK(median.median_m() == 3.0);  // the upper one

  const TemporaryFolder folder;
  write_prior(folder / "prior.toml", prior);
  const DepthPrior again = read_prior(folder / "prior.toml");
  CHECK(again.median_m == prior.median_m);
  CHECK(again.row_depth_m == prior.row_depth_m);
  CHECK(again.images == 2);
}

TEST_CASE("a prior that cannot be fitted or read says why") {
  DepthPriorFit fit;
  CHECK_THROWS_WITH(fit.result(), Contains("holds any truth"));
  fit.add(picture(2, {0, 0, 0, 0}), {});
  CHECK_THROWS_WITH(fit.result(), Contains("holds any truth"));
  CHECK_THROWS_WITH(fit.add(picture(2, {1, 1}), {}), Contains("grids of 2 and 1 rows"));

  const TemporaryFolder folder;
  const auto path = folder / "prior.toml";
  CHECK_THROWS_WITH((void)read_prior(path), Contains("prior.toml: cannot be opened"));
  write_text_file(path, "median_m = [\n");
  CHECK_THAT(complaint(path), Contains("is no valid TOML") && Contains("--fit-prior"));
  write_text_file(path, "row_depth_m = [1.0]\n");
  CHECK_THAT(complaint(path), Contains("`median_m` must be metres above 0"));
  write_text_file(path, "median_m = -2.0\nrow_depth_m = [1.0]\n");
  CHECK_THAT(complaint(path), Contains("`median_m` must be metres above 0"));
  write_text_file(path, "median_m = 2.0\n");
  CHECK_THAT(complaint(path), Contains("`row_depth_m` must be a list"));
  write_text_file(path, "median_m = 2.0\nrow_depth_m = [1.0, inf]\n");
  CHECK_THAT(complaint(path), Contains("`row_depth_m` must be metres"));
  write_text_file(path, "median_m = 2.0\nrow_depth_m = []\n");
  CHECK_THAT(complaint(path), Contains("`row_depth_m` must be a list"));
}
