#include "egofocus/engine.hpp"

#include <atomic>

#include "core/arena.hpp"
#include "core/clock.hpp"
#include "core/inlets.hpp"
#include "core/mailbox.hpp"
#include "core/rt_thread.hpp"
#include "core/snapshot.hpp"
#include "core/worker_pool.hpp"
#include "pipeline/check_config.hpp"
#include "pipeline/pipeline.hpp"
#include "pipeline/scheduler.hpp"

namespace egofocus {
namespace {

constexpr int kMaxSources = 8;
constexpr std::int64_t kPollTimeout_us = 10'000;
constexpr std::int64_t kAheadLimit_us = 1'000'000;
constexpr std::int64_t kLateTick_us = 1000;
constexpr std::int64_t kLatestTick_us = std::int64_t{1}
                                        << 60;  // a grid that goes on from there overflows nothing
// A source that brings nothing this many times in a row under the virtual clock will not bring anything.
constexpr int kIdlePolls = 100;

struct AttachedSource {
  Source source;
  Delivery newest;
  Inlets* inlets = nullptr;
  const std::atomic<bool>* stopping = nullptr;
  RtThread thread;
  bool started = false;
  std::atomic<bool> lost{false};

  // An error of the transport ends the source and is counted: nothing more comes, and nobody waits for it.
  void poll(std::int64_t until_us, std::int64_t timeout_us) noexcept {
    newest = source.poll(source.self, *inlets, until_us, timeout_us);
    if (newest.status.ok()) return;
    newest.ended = true;
    lost.store(true, std::memory_order_relaxed);
  }
};

// A live source: polled on its own thread, each wait bounded.
void poll_until_stopped(void* self) noexcept {
  auto& attached = *static_cast<AttachedSource*>(self);
  while (!attached.stopping->load(std::memory_order_relaxed) && !attached.newest.ended) {
    attached.poll(INT64_MAX, kPollTimeout_us);
  }
}

}  // namespace

struct Engine::State {
  State(const Config& c, const Model& model, Arena& arena) noexcept
      : config(c),
        kernels(select_kernels(detect_isa() & c.isa_mask)),
        rings{SpscRing<Event>(arena.part(ArenaPart::kRings).array<Event>(c.rings.events)),
              SpscRing<ImuSample>(arena.array<ImuSample>(c.rings.imu)),
              SpscRing<OdometrySample>(arena.array<OdometrySample>(c.rings.odometry)),
              SpscRing<PoseSample>(arena.array<PoseSample>(c.rings.poses)),
              EventThinner(c.rings.max_event_rate_hz)},
        inlets(rings),
        pipeline(c, model, kernels, arena) {
    config.filter.hot_pixels = {};
    config.model = {};
    name_kernels(kernels, c.backend == Backend::kNetwork, isa);
    arena.part(ArenaPart::kDepth);
    const Intrinsics grid = working_grid(c);
    const auto pixels = static_cast<std::size_t>(grid.width_px) * static_cast<std::size_t>(grid.height_px);
    for (int i = 0; i < 3; ++i) {
      frames.slots()[i].inverse_depth = arena.array<std::uint16_t>(pixels);
      frames.slots()[i].confidence = arena.array<std::uint8_t>(pixels);
    }
  }

  bool deliver_until(std::int64_t tick_us) noexcept;

  Config config;
  KernelTable kernels;
  char isa[96] = {};
  Inlets::Rings rings;
  Inlets inlets;
  Pipeline pipeline;
  WorkerPool pool;
  Mailbox<FrameSlot> frames;
  Snapshot<Health> health;
  Health counted;  // the tick thread's own copy
  Scheduler scheduler;
  Clock clock;
  ClockKind clock_kind = ClockKind::kVirtual;
  AttachedSource sources[kMaxSources];
  int source_count = 0;
  bool started = false;
  std::atomic<bool> stopping{false};
};

// `config` becomes the one that is used, `model` that of the network backend.
Status Engine::plan(Config& config, Model& model, ArenaBytes& bytes_out) noexcept {
  bytes_out = {};
  // Twice: what the model puts in place of some of it is not what was asked for.
  if (Status status = check_config(config); !status.ok()) return status;
  if (Status status = adopt_model(config, model); !status.ok()) return status;
  if (Status status = check_config(config); !status.ok()) return status;
  Arena counter;
  static_cast<void>(counter.array<std::byte>(sizeof(State)));
  const State probe(config, model, counter);
  bytes_out.all = counter.used_bytes();
  bytes_out.engine = counter.used_bytes(ArenaPart::kEngine);
  bytes_out.rings = counter.used_bytes(ArenaPart::kRings);
  bytes_out.window = counter.used_bytes(ArenaPart::kWindow);
  bytes_out.motion = counter.used_bytes(ArenaPart::kMotion);
  bytes_out.warp = counter.used_bytes(ArenaPart::kWarp);
  bytes_out.backend = counter.used_bytes(ArenaPart::kBackend);
  bytes_out.weights = counter.used_bytes(ArenaPart::kWeights);
  bytes_out.depth = counter.used_bytes(ArenaPart::kDepth);
  return {};
}

Status Engine::required_arena(const Config& config, ArenaBytes& bytes_out) noexcept {
  Config used = config;
  Model model;
  return plan(used, model, bytes_out);
}

Status Engine::required_arena(const Config& config, std::size_t& bytes_out) noexcept {
  ArenaBytes bytes;
  const Status status = required_arena(config, bytes);
  bytes_out = bytes.all;
  return status;
}

Status Engine::configure(const Config& asked, std::span<std::byte> block) noexcept {
  if (state_ != nullptr) return {StatusCode::kBadState, "configure() twice; make another Engine"};
  Config config = asked;
  Model model;
  ArenaBytes needed;
  if (Status status = plan(config, model, needed); !status.ok()) return status;
  if (block.size() < needed.all) {
    return {StatusCode::kArenaTooSmall, "arena", static_cast<std::int64_t>(block.size()),
            static_cast<std::int64_t>(needed.all)};
  }
  const auto address = reinterpret_cast<std::uintptr_t>(block.data());
  if (address % Arena::kAlignment != 0) {
    return {StatusCode::kArenaMisaligned, "arena", static_cast<std::int64_t>(address % Arena::kAlignment)};
  }
  Arena arena(block);
  state_ = arena.object<State>(config, model, arena);
  state_->pipeline.prepare(config);
  return {};
}

Status Engine::attach(const Source& source) noexcept {
  if (state_ == nullptr) return {StatusCode::kBadState, "attach() before configure()"};
  if (state_->started) return {StatusCode::kBadState, "attach() after start()"};
  if (source.poll == nullptr) return {StatusCode::kBadState, "attach() of a source without poll"};
  if (state_->source_count == kMaxSources)
    return {StatusCode::kTooManySources, "attach()", kMaxSources + 1, kMaxSources};
  AttachedSource& attached = state_->sources[state_->source_count++];
  attached.source = source;
  attached.inlets = &state_->inlets;
  attached.stopping = &state_->stopping;
  return {};
}

Status Engine::watch_events(const EventTap& tap) noexcept {
  if (state_ == nullptr) return {StatusCode::kBadState, "watch_events() before configure()"};
  if (state_->started) return {StatusCode::kBadState, "watch_events() after start()"};
  state_->rings.tap = tap;
  return {};
}

Status Engine::start(ClockKind clock, std::int64_t first_tick_us) noexcept {
  if (state_ == nullptr) return {StatusCode::kBadState, "start() before configure()"};
  State& s = *state_;
  if (s.started) return {StatusCode::kBadState, "start() twice"};
  s.clock_kind = clock;
  s.clock = monotonic_clock();
  s.stopping.store(false, std::memory_order_relaxed);
  s.scheduler.start(s.config.rate, first_tick_us);
  const RealTimeConfig rt = clock == ClockKind::kMonotonic ? s.config.real_time : RealTimeConfig{};
  if (rt.lock_memory) s.counted.refused |= lock_memory();
  if (Status status = s.pool.start(s.config.threads, rt.fifo_priority, rt.cpu); !status.ok()) return status;
  s.started = true;  // from here on stop() cleans up
  for (int i = 0; i < s.source_count; ++i) {
    AttachedSource& attached = s.sources[i];
    attached.newest = {};
    Status status;
    if (attached.source.start != nullptr) status = attached.source.start(attached.source.self);
    attached.started = status.ok();
    if (status.ok() && clock == ClockKind::kMonotonic) {
      status = attached.thread.start({"egofocus-in", rt.fifo_priority, -1}, poll_until_stopped, &attached);
    }
    if (!status.ok()) {
      stop();
      return status;
    }
  }
  // Last, so that no other thread inherits the priority and the pin of the tick.
  s.counted.refused |= make_this_thread_real_time({"egofocus-tick", rt.fifo_priority, rt.cpu});
  s.health.publish(s.counted);
  return {};
}

Status Engine::set_next_tick(std::int64_t t_us) noexcept {
  if (state_ == nullptr || !state_->started) {
    return {StatusCode::kBadState, "set_next_tick() before start() or after stop()"};
  }
  State& s = *state_;
  if (s.clock_kind == ClockKind::kMonotonic) {
    return {StatusCode::kBadState, "set_next_tick() with the monotonic clock, whose ticks are a grid"};
  }
  const std::int64_t last_us = s.pipeline.last_tick_us();
  if (t_us <= last_us) return {StatusCode::kBadTick, "it must come after the last one", t_us, last_us};
  if (t_us > kLatestTick_us)
    return {StatusCode::kBadTick, "it is later than the latest", t_us, kLatestTick_us};
  s.scheduler.move_to(t_us);
  return {};
}

// Asks every source for all up to the tick, and empties the rings as they fill; live ones are waited for.
// False when there is no source left that reaches the tick and nothing new came either.
bool Engine::State::deliver_until(std::int64_t tick_us) noexcept {
  const bool is_live = clock_kind == ClockKind::kDevice;
  std::uint64_t taken_in_all = pipeline.ingest(rings, tick_us, INT64_MAX);
  bool all_ended = source_count > 0;
  for (int idle = 0; idle < kIdlePolls && !stopping.load(std::memory_order_relaxed);) {
    bool waiting = false;
    for (int i = 0; i < source_count; ++i) {
      AttachedSource& attached = sources[i];
      if (attached.newest.ended || attached.newest.watermark_us >= tick_us) continue;
      attached.poll(tick_us, is_live ? kPollTimeout_us : 0);
      waiting |= !attached.newest.ended && attached.newest.watermark_us < tick_us;
    }
    const std::uint64_t taken = pipeline.ingest(rings, tick_us, INT64_MAX);
    taken_in_all += taken;
    idle = taken > 0 || is_live ? 0 : idle + 1;
    if (!waiting) break;
  }
  for (int i = 0; i < source_count; ++i) all_ended &= sources[i].newest.ended;
  return !all_ended || taken_in_all > 0;
}

bool Engine::tick() noexcept {
  if (state_ == nullptr || !state_->started) return false;
  State& s = *state_;
  if (s.stopping.load(std::memory_order_relaxed)) return false;
  std::int64_t tick_us = s.scheduler.tick_us();
  std::int64_t late_us = 0;
  if (s.clock_kind != ClockKind::kMonotonic) {
    if (!s.deliver_until(tick_us)) return false;
  } else {
    late_us = s.scheduler.wait(s.clock, s.stopping);
    if (s.config.rate.max_late_us > 0 && late_us > s.config.rate.max_late_us) {
      s.counted.ticks.skipped += s.scheduler.catch_up(s.scheduler.deadline_us() + late_us);
      late_us -= s.scheduler.tick_us() - tick_us;
      tick_us = s.scheduler.tick_us();
    }
    s.pipeline.ingest(s.rings, tick_us, kAheadLimit_us);
  }
  if (s.stopping.load(std::memory_order_relaxed)) return false;

  FrameSlot& slot = s.frames.back();
  s.pipeline.tick(tick_us, s.pool, slot);

  slot.frame.sequence = s.scheduler.index();
  if (s.clock_kind != ClockKind::kMonotonic) {
    s.scheduler.advance();
  } else {
    const std::int64_t now_us = s.clock.now_us(s.clock.self);
    slot.frame.latency_us = now_us - tick_us;
    if (late_us > kLateTick_us) {
      slot.frame.flags |= kLateTick;
      ++s.counted.ticks.late;
    }
    s.counted.ticks.skipped += s.scheduler.advance(now_us);
  }
  s.frames.publish();

  s.pipeline.report(s.counted);
  s.counted.events.over_rate = s.rings.over_rate.load(std::memory_order_relaxed);
  s.counted.events.in = s.rings.events.offered() + s.counted.events.over_rate;
  s.counted.events.ring_dropped = s.rings.events.dropped();
  const auto count_ring = [](SampleCounters& counters, const auto& ring) {
    counters.in = ring.offered();
    counters.ring_dropped = ring.dropped();
  };
  count_ring(s.counted.imu, s.rings.imu);
  count_ring(s.counted.odometry, s.rings.odometry);
  count_ring(s.counted.poses, s.rings.poses);
  s.counted.sources_lost = 0;
  for (int i = 0; i < s.source_count; ++i)
    s.counted.sources_lost += s.sources[i].lost.load(std::memory_order_relaxed);
  s.health.publish(s.counted);
  return true;
}

bool Engine::newest(DepthFrame& frame_out) noexcept {
  const FrameSlot* slot = state_ != nullptr ? state_->frames.newest() : nullptr;
  if (slot == nullptr) return false;
  frame_out = slot->frame;
  return true;
}

std::int64_t Engine::next_tick_us() const noexcept {
  return state_ != nullptr ? state_->scheduler.tick_us() : INT64_MIN;
}
Inlets Engine::inlets() noexcept {
  return state_->inlets;
}

Health Engine::health() const noexcept {
  Health health;
  if (state_ != nullptr) static_cast<void>(state_->health.read(health));
  return health;
}

const char* Engine::isa() const noexcept {
  return state_ != nullptr ? state_->isa : "";
}

void Engine::request_stop() noexcept {
  if (state_ != nullptr) state_->stopping.store(true, std::memory_order_relaxed);
}

void Engine::stop() noexcept {
  if (state_ == nullptr || !state_->started) return;
  State& s = *state_;
  s.stopping.store(true, std::memory_order_relaxed);
  for (int i = 0; i < s.source_count; ++i) {
    AttachedSource& attached = s.sources[i];
    attached.thread.join();
    if (attached.started && attached.source.stop != nullptr) attached.source.stop(attached.source.self);
    attached.started = false;
  }
  s.pool.stop();
  s.started = false;
}

Engine::~Engine() {
  stop();
  if (state_ != nullptr) state_->~State();
}

}  // namespace egofocus
