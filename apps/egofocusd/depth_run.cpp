#include "depth_run.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <string>

#include "recording/recording_source.hpp"

namespace egofocus::daemon {
namespace {

using recording::Error;
using recording::ExitCode;
using recording::require;

constexpr timespec kShortly{0, 5'000'000};

void* pages(std::size_t bytes) noexcept {
  void* const block = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return block == MAP_FAILED ? nullptr : block;
}

}  // namespace

DepthRun::DepthRun(std::unique_ptr<Setup> setup)
    : setup_(std::move(setup)),
      happened_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      arena_(pages(setup_->arena_bytes), {setup_->arena_bytes}) {
  if (!arena_ || !happened_.is_open()) {
    throw Error(ExitCode::kMemory, "no memory for an arena of " + std::to_string(setup_->arena_bytes) +
                                       " bytes. Free some, or choose fewer hypotheses or a smaller grid.");
  }
  require(
      engine_.configure(setup_->camera.config, {static_cast<std::byte*>(arena_.get()), setup_->arena_bytes}),
      setup_->camera_file.string());
}

DepthRun::~DepthRun() {
  request_stop();
  thread_.join();
}

void DepthRun::start(DepthMemory& memory, Recorder& recorder) {
  memory_ = &memory;
  sources_ = open_sources(*setup_, recorder);
  for (const Source& source : sources_.to_attach)
    require(engine_.attach(source), source.name, ExitCode::kInternal);
  require(engine_.watch_events({&recorder,
                                [](void* self, std::span<const Event> events) noexcept {
                                  static_cast<Recorder*>(self)->take(events);
                                }}),
          "recorder", ExitCode::kInternal);
  may_tick_.store(!setup_->daemon.source.wait_for_reader, std::memory_order_relaxed);
  require(
      thread_.start(
          {"egofocus-tick", 0, -1}, [](void* self) noexcept { static_cast<DepthRun*>(self)->work(); }, this),
      "egofocusd", ExitCode::kMemory);
}

std::vector<DeviceFact> DepthRun::devices() const {
  std::vector<DeviceFact> facts;
  for (const auto& tell_of_one : sources_.devices) tell_of_one(facts);
  return facts;
}

void DepthRun::request_stop() noexcept {
  stopping_.store(true, std::memory_order_relaxed);
  engine_.request_stop();
}

std::unique_ptr<Setup> DepthRun::end() {
  request_stop();
  thread_.join();
  return std::move(setup_);
}

// The thread that owns the engine. Its priority and its pin come from Engine::start().
void DepthRun::work() noexcept {
  while (!may_tick_.load(std::memory_order_acquire) && !stopping_.load(std::memory_order_relaxed))
    ::nanosleep(&kShortly, nullptr);
  failure_ = engine_.start(setup_->daemon.source.clock, sources_.first_tick_us);
  if (!failure_.ok()) return tell(State::kFailed);
  tell(State::kRunning);
  DepthFrame frame;
  while (!stopping_.load(std::memory_order_relaxed) && !sources_.ends_before(engine_.next_tick_us()) &&
         engine_.tick()) {
    if (engine_.newest(frame)) memory_->publish(frame);
    ticks_.fetch_add(1, std::memory_order_relaxed);
    tell();
  }
  engine_.stop();
  tell(State::kEnded);
}

void DepthRun::tell(State state) noexcept {
  state_.store(state, std::memory_order_release);
  tell();
}

void DepthRun::tell() noexcept {
  const std::uint64_t one = 1;
  static_cast<void>(::write(happened_.number(), &one, sizeof one) == 0);
}

void DepthRun::forget_happened() noexcept {
  std::uint64_t count = 0;
  static_cast<void>(::read(happened_.number(), &count, sizeof count) == 0);
}

}  // namespace egofocus::daemon
