// Builds with EGOFOCUS_CHECK_KERNELS: a body that is wrong in one byte ends the process, with its name and
// the place.
#include "kernels/checked_kernels.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <string>
#include <vector>

#include "kernels/kernel_table.hpp"

using namespace egofocus;

namespace {

/// What a process that does this writes to stderr, when it aborts; "" when it does not.
template <class Action>
std::string last_words(Action action) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGABRT, SIG_DFL);  // not the test runner's
    dup2(ends[1], STDERR_FILENO);
    action();
    _exit(0);
  }
  close(ends[1]);
  std::string words;
  char piece[200];
  for (ssize_t n = 0; (n = read(ends[0], piece, sizeof piece)) > 0;)
    words.append(piece, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT ? words : "";
}

/// Two inputs, five outputs, 1x1, three pixels; weights of the scalar packing.
struct SmallConv {
  std::vector<std::uint8_t> input = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  std::vector<std::int8_t> weights = std::vector<std::int8_t>(20, 1);
  std::vector<std::int32_t> bias = std::vector<std::int32_t>(5, 20);
  std::vector<float> scale = std::vector<float>(5, 0.5f);
  std::vector<std::uint8_t> output = std::vector<std::uint8_t>(15);

  ConvU8S8 call() {
    ConvU8S8 conv;
    conv.input = input.data();
    conv.input_pixel_stride = conv.in_channels = 4;
    conv.input_row_stride = 12;
    conv.packed = {weights.data(), bias.data(), scale.data()};
    conv.output = output.data();
    conv.output_pixel_stride = conv.out_channels = 5;
    conv.output_row_stride = 15;
    conv.columns = 3;
    conv.rows = 1;
    return conv;
  }
};

/// Two events of two hypotheses on 8x4 px.
struct SmallVote {
  std::vector<std::int32_t> u = {3 << 16, 5 << 16}, v = {1 << 16, 2 << 16}, du = {1 << 16, 0}, dv = {0, 0};
  std::vector<std::uint8_t> k_end = {2, 2};
  std::vector<std::uint8_t> stack = std::vector<std::uint8_t>(64);
  std::vector<std::uint32_t> scratch = std::vector<std::uint32_t>(32);

  WarpVote call() {
    WarpVote vote;
    vote.u_q16 = u.data();
    vote.v_q16 = v.data();
    vote.du_q16 = du.data();
    vote.dv_q16 = dv.data();
    vote.k_end = k_end.data();
    vote.n = 2;
    vote.k_begin = 4;
    vote.k_count = 2;
    vote.width = vote.row_stride = 8;
    vote.height = 4;
    vote.plane_stride = 32;
    vote.stack = stack.data();
    vote.scratch = scratch.data();
    return vote;
  }
};

}  // namespace

TEST_CASE("a convolution that is wrong in one byte is named with the place") {
  SmallConv small;
  const ConvU8S8 conv = small.call();
  check_conv_u8s8(&conv_u8s8_scalar, Isa::kScalar, kConvPacking_scalar, conv);
  CHECK(small.output[14] == 31);  // (9 + 10 + 11 + 12 + 20) / 2
  const auto wrong = [](const ConvU8S8& c) noexcept {
    conv_u8s8_scalar(c);
    ++static_cast<std::uint8_t*>(c.output)[2 * 5 + 3];
  };
  const std::string words =
      last_words([&] { check_conv_u8s8(wrong, Isa::kAvx2, kConvPacking_scalar, conv); });
  INFO(words);
  CHECK(words.find("conv_u8s8 avx2 differs from scalar: row 0, column 2, output 3: byte 32 in place of 31") !=
        std::string::npos);
}

TEST_CASE("a vote that is wrong in one byte, in its number or in its scratch is named with the place") {
  SmallVote small;
  const WarpVote vote = small.call();
  for (std::uint8_t& k : small.k_end) k = 6;
  CHECK(check_warp_vote(&warp_vote_u8_scalar, Isa::kScalar, vote) == 3);  // one leaves the grid
  const auto spoiled = [&](WarpVoteFunction* wrong) {
    return last_words([&] { check_warp_vote(wrong, Isa::kNeon, vote); });
  };
  const std::string counts = spoiled([](const WarpVote& v) noexcept {
    const std::int64_t votes = warp_vote_u8_scalar(v);
    ++v.stack[32 + 8 + 2];
    return votes;
  });
  INFO(counts);
  CHECK(counts.find(
            "warp_vote neon differs from scalar: counts, hypothesis 5, row 1, column 2: 1 in place of 0") !=
        std::string::npos);
  CHECK(spoiled([](const WarpVote& v) noexcept {
          return warp_vote_u8_scalar(v) + 1;
        }).find("number of votes") != std::string::npos);
  CHECK(spoiled([](const WarpVote& v) noexcept {
          v.scratch[9] = 1;
          return warp_vote_u8_scalar(v);
        }).find("scratch left behind") != std::string::npos);
}

TEST_CASE("the table's kernels are the checked ones") {
  const KernelTable table = select_kernels(0);
  CHECK(table.conv_u8s8.run != &conv_u8s8_scalar);
  SmallVote small;
  const WarpVote vote = small.call();
  CHECK(table.warp_vote.run(vote) == 0);  // k_end lies before the first hypothesis
  small.scratch[3] = 1;                   // against the contract; the scalar meaning does not look
  CHECK_FALSE(last_words([&] { table.warp_vote.run(vote); }).empty());
}
