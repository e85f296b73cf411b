// network_frames MODEL CASES: runs the network on the first window of CASES (cases.bin of
// egofocus_training.vectors) on one thread. The first frame is held against the integer model's index in
// CASES; then a line "peak N" tells the most memory so far, KiB. For each number n on a line of the input: n
// frames, and their times in ms, of the process's processors, on one line. peer_onnxruntime.py drives it.
#include <time.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>

#include "kernels/isa.hpp"
#include "pipeline/half_counts.hpp"
#include "pipeline/network.hpp"
#include "support/arena_block.hpp"
#include "support/network_vectors.hpp"

namespace {

using namespace egofocus;
using test::VectorArray;
using test::VectorCase;

double process_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Not getrusage(): that one remembers the process that this one was started from.
long peak_kib() {
  std::ifstream status("/proc/self/status");
  long kib = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") status >> kib;
  }
  return kib;
}

class Frames {
 public:
  Frames(const std::string& model_path, const std::string& cases_path)
      : file_(test::file_bytes(model_path)),
        window_(std::move(test::read_cases(cases_path).at(0))),
        model_(std::make_unique<Model>()) {
    if (!read_model(file_.bytes(), *model_).ok()) throw std::runtime_error(model_path + ": not a model");
    const VectorArray& half = window_.at("half");
    const std::size_t cells = half.shape[1] * half.shape[2];
    half_.resize(half.shape[0] * half_counts_bytes(cells));
    for (std::size_t k = 0; k < half.shape[0]; ++k)
      pack_half_counts(std::span(half.bytes).subspan(k * cells, cells), &half_[k * half_counts_bytes(cells)]);
    Intrinsics grid;
    grid.width_px = static_cast<std::int32_t>(2 * half.shape[2]);
    grid.height_px = static_cast<std::int32_t>(2 * half.shape[1]);
    const KernelTable kernels = select_kernels(detect_isa());
    Arena counter;
    MemoryPlan counted;
    make(grid, kernels, counted, counter);
    block_ = std::make_unique<test::ArenaBlock>(counter.used_bytes());
    Arena arena(block_->span());
    MemoryPlan plan;
    make(grid, kernels, plan, arena);
    if (!pool_.start(1, 0, -1).ok()) throw std::runtime_error("no pool");
  }

  CellDepth run() {
    return network_->run({window_.at("focus").bytes, window_.at("context").bytes, half_,
                          static_cast<std::int32_t>(window_.at("used").at(0))},
                         pool_);
  }

  void check() {
    const CellDepth out = run();
    const VectorArray& index = window_.at("index");
    std::size_t i = 0;
    while (i < index.size() && out.index_q8.size() == index.size() && out.index_q8[i] == index.at(i)) ++i;
    if (i != index.size()) throw std::runtime_error("not what the integer model says");
  }

 private:
  void make(const Intrinsics& grid, const KernelTable& kernels, MemoryPlan& plan, Arena& arena) {
    const Network::Buffers buffers(model_->facts, grid, 1, plan);
    plan.place(arena);
    network_ = std::make_unique<Network>(*model_, grid, kernels, 1, buffers, plan, arena);
  }

  test::ModelMemory file_;
  VectorCase window_;
  std::unique_ptr<Model> model_;
  std::vector<std::uint8_t> half_;
  std::unique_ptr<test::ArenaBlock> block_;
  std::unique_ptr<Network> network_;
  WorkerPool pool_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fprintf(stderr, "usage: network_frames MODEL CASES\n");
    return 2;
  }
  Frames frames(argv[1], argv[2]);
  frames.check();
  std::printf("peak %ld\n", peak_kib());
  std::fflush(stdout);
  for (int count = 0; std::cin >> count;) {
    for (int n = 0; n < count; ++n) {
      const double start = process_ms();
      frames.run();
      std::printf("%.4f ", process_ms() - start);
    }
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
