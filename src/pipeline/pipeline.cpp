#include "pipeline/pipeline.hpp"

#include "pipeline/in_parts.hpp"

namespace egofocus {
namespace {

std::optional<NetworkMemory> network_memory(const Config& config, const Model& model, Arena& arena) noexcept {
  if (config.backend != Backend::kNetwork) return std::nullopt;
  return std::optional<NetworkMemory>(std::in_place, config, model, arena);
}

Warp make_warp(const Config& config, const KernelTable& kernels, const std::optional<NetworkMemory>& shared,
               Arena& arena) noexcept {
  if (!shared) return Warp(config, kernels, arena);
  return Warp(config, kernels, arena, shared->lines());
}

}  // namespace

Pipeline::Pipeline(const Config& config, const Model& model, const KernelTable& kernels,
                   Arena& arena) noexcept
    : config_(config),
      grid_(working_grid(config)),
      filter_(config, arena.part(ArenaPart::kWindow)),
      window_(config.window, config.camera.intrinsics, arena),
      ego_motion_(arena.part(ArenaPart::kMotion).object<EgoMotion>(config.motion)),
      track_(arena.object<MotionTrack>()),
      network_memory_(network_memory(config, model, arena.part(ArenaPart::kBackend))),
      warp_(make_warp(config, kernels, network_memory_, arena.part(ArenaPart::kWarp))),
      depth_decode_(grid_, !network_memory_, arena.part(ArenaPart::kDepth)),
      carried_(config.carry, grid_, network_memory_ ? network_memory_->idle() : warp_.scratch(), arena) {
  arena.part(ArenaPart::kBackend);
  if (network_memory_) {
    network_.emplace(config, model, kernels, *network_memory_, arena);
    if (config.carry.fuse_us > 0) fused_.emplace(config.carry, grid_, arena.part(ArenaPart::kDepth));
  } else {
    focus_.emplace(config, config.threads, arena);
  }
  config_.model = {};
  config_.filter.hot_pixels = {};  // the caller's memory is not ours after set-up
}

void Pipeline::prepare(const Config& config) noexcept {
  warp_.prepare(config.camera);
}

// --- the algorithm -----------------------------------------------------------------------------------

void Pipeline::tick(std::int64_t tick_us, WorkerPool& pool, FrameSlot& out) noexcept {
  StageWatch watch;
  DepthFrame& frame = out.frame;
  frame = {};
  frame.t_us = tick_us;
  frame.grid = grid_;
  frame.inverse_depth = out.inverse_depth;
  frame.confidence = out.confidence;

  // 1. How the camera moved, as far back as a window may reach.
  ego_motion_->advance(tick_us);
  const std::int64_t known_from_us = ego_motion_->earliest_us();
  std::int64_t oldest_us = tick_us - config_.window.max_age_us;
  count_outside_motion(oldest_us, known_from_us, tick_us);
  if (oldest_us < known_from_us) oldest_us = known_from_us;
  const bool has_motion = oldest_us < tick_us && track(oldest_us, oldest_us, tick_us);
  frame.window_begin_us = oldest_us < tick_us ? oldest_us : tick_us;

  // 2. The hypotheses that this motion can tell apart, and the window that they need.
  HypothesisLadder ladder;
  EventWindow::Selection selection;
  if (!has_motion) {
    frame.flags |= kNoMotion;
  } else {
    const CameraMotion motion = ego_motion_->at_end(tick_us);
    for (int i = 0; i < 3; ++i) {
      frame.velocity_m_s[i] = motion.velocity_m_s[i];
      frame.angular_rate_rad_s[i] = motion.angular_rate_rad_s[i];
    }
    frame.velocity_sigma_m_s = speed_sigma_m_s(motion);
    if (ego_motion_->is_stale(tick_us)) frame.flags |= kStaleVelocity;
    ladder = choose_ladder(config_.ladder, grid_, *track_);
    frame.window_begin_us = ladder.begin_us;
    if (!ladder.has_parallax) frame.flags |= kNoParallax;
    selection = window_.select(ladder.begin_us, tick_us);
  }
  const bool too_few =
      selection.count == 0 || selection.count < static_cast<std::uint32_t>(config_.window.min_events);
  if (has_motion && too_few) frame.flags |= kTooFewEvents;
  window_counters_.decimated += selection.in_window - selection.count;
  if (lost_before_ring_ != lost_before_tick_ || selection.in_window != selection.count)
    frame.flags |= kOverload;
  lost_before_tick_ = lost_before_ring_;

  // 3. Where nothing can be measured well: the last measured depth, seen from here.
  follow(has_motion, tick_us);
  const bool has_stack = has_motion && ladder.has_parallax && selection.count > 0;
  const bool carried = (!has_stack || (too_few && !carried_.few_events())) && carry(tick_us, out);

  // 4. Events -> stack of warped images -> focus -> depth.
  if (!carried && has_stack && track(oldest_us, ladder.begin_us, tick_us)) {
    StageTimes stages;
    stages.motion_us = watch.lap_us();
    CellDepth cells = depth_of_cells(selection, ladder, pool, watch, stages);
    if (fused_) cells = fuse(cells, ladder, oldest_us, tick_us, pool);
    depth_decode_.run(cells, pool, out.inverse_depth, out.confidence);
    stages.depth_us = watch.lap_us();
    stages.all_us = watch.all_us();
    stages_ = stages;
    frame.events = selection.count;
    frame.votes = warp_.votes();
    frame.hypotheses = ladder.count;
    frame.inverse_depth_scale_per_m = ladder.step_per_m / 256.0;
    frame.parallax_px = ladder.parallax_px;
    window_counters_.behind_camera += warp_.behind_camera();
    last_depth_event_us_ = window_.newest_us();
    carried_.keep(frame, last_depth_event_us_);
  } else if (!carried) {
    blank(out);
  }
  frame.age_us = last_depth_event_us_ == INT64_MIN ? INT64_MAX : tick_us - last_depth_event_us_;
  conclude(frame);
  last_tick_us_ = tick_us;
}

CellDepth Pipeline::depth_of_cells(const EventWindow::Selection& selection, const HypothesisLadder& ladder,
                                   WorkerPool& pool, StageWatch& watch, StageTimes& stages) noexcept {
  const double(&baseline_m)[3] = track_->knots[0].centre_m;
  in_parts(pool, [&](int part, int parts) noexcept {
    warp_.project(window_, selection, *track_, ladder, part, parts);
  });
  CellDepth cells;
  if (network_) {
    network_->vote(warp_, ladder, baseline_m, pool);
    stages.warp_us = watch.lap_us();
    network_->prepare_input(pool);
    stages.input_us = watch.lap_us();
    cells = network_->run(pool);
  } else {
    in_parts(pool, [this](int part, int parts) noexcept { warp_.vote(part, parts); });
    stages.warp_us = watch.lap_us();
    cells = focus_->run(warp_, ladder, baseline_m, pool);
  }
  stages.backend_us = watch.lap_us();
  return cells;
}

CellDepth Pipeline::fuse(const CellDepth& cells, const HypothesisLadder& ladder, std::int64_t oldest_us,
                         std::int64_t tick_us, WorkerPool& pool) noexcept {
  const std::int64_t seen_us = fused_->seen_us();
  const bool knows_way =
      fused_->kept_at(tick_us) && seen_us >= oldest_us && track(oldest_us, seen_us, tick_us);
  return fused_->fuse(cells, ladder.step_per_m, tick_us, knows_way ? &track_->knots[0] : nullptr, pool);
}

bool Pipeline::track(std::int64_t oldest_us, std::int64_t begin_us, std::int64_t tick_us) noexcept {
  if (config_.velocity_noise.percent > 0)
    return noisy_track(config_.velocity_noise, *ego_motion_, oldest_us, begin_us, tick_us, *track_);
  return ego_motion_->track(begin_us, tick_us, *track_);
}

// What the newest samples say of the way since the kept depth stays; what is only held beyond them is for one
// tick alone, in carry().
void Pipeline::follow(bool has_motion, std::int64_t tick_us) noexcept {
  if (!has_motion) carried_.drop();
  if (!carried_.kept()) return;
  const std::int64_t followed_us = carried_.followed_us();
  const std::int64_t newest_us = ego_motion_->newest_us() < tick_us ? ego_motion_->newest_us() : tick_us;
  if (newest_us <= followed_us) return;
  if (track(followed_us, followed_us, newest_us)) {
    carried_.follow(*track_);
  } else {
    carried_.drop();
  }
}

bool Pipeline::carry(std::int64_t tick_us, FrameSlot& out) noexcept {
  const std::int64_t followed_us = carried_.followed_us();
  return carried_.kept() && track(followed_us, followed_us, tick_us) &&
         carried_.show(*track_, out.frame, out.inverse_depth, out.confidence);
}

// --- in and out --------------------------------------------------------------------------------------

std::uint64_t Pipeline::ingest_events(SpscRing<Event>& ring, std::int64_t tick_us,
                                      std::int64_t horizon_us) noexcept {
  std::uint64_t taken = 0;
  EventCounters& counters = filter_.counters();
  for (;;) {
    const std::span<const Event> ready = ring.peek(1024);
    std::size_t n = 0;
    for (; n < ready.size(); ++n) {
      const Event& event = ready[n];
      if (event.t_us > tick_us) {
        if (event.t_us <= horizon_us) break;
        ++counters.ahead;
      } else if (event.t_us <= last_tick_us_) {
        ++counters.late;
      } else if (filter_.keep(event)) {
        window_.add(event);
      }
    }
    ring.release(n);
    taken += n;
    if (n == 0 || n < ready.size()) return taken;
  }
}

std::uint64_t Pipeline::ingest(Inlets::Rings& rings, std::int64_t tick_us, std::int64_t ahead_us) noexcept {
  lost_before_ring_ = rings.events.dropped() + rings.over_rate.load(std::memory_order_relaxed);
  const std::int64_t horizon_us = tick_us > INT64_MAX - ahead_us ? INT64_MAX : tick_us + ahead_us;
  std::uint64_t taken = ingest_events(rings.events, tick_us, horizon_us);
  // The ego-motion sorts; what is newer than the tick waits in its ring, so that nothing depends on arrival.
  const auto next = [&](auto& ring, std::uint64_t& ahead) {
    auto ready = ring.peek(1);
    for (; !ready.empty() && ready[0].t_us > horizon_us; ready = ring.peek(1)) {
      ++ahead;  // not for the ego-motion: it would wait there, and fill up what sorts
      ring.release(1);
      ++taken;
    }
    return !ready.empty() && ready[0].t_us <= tick_us ? ready.data() : nullptr;
  };
  const auto take = [&](auto& ring, const auto& sample) {
    ego_motion_->add(sample);
    ring.release(1);
    ++taken;
  };
  // By time, not ring by ring: after a long pause one kind alone would fill up what sorts, and its oldest
  // samples, used early, would make the other kind's late.
  for (;;) {
    const ImuSample* const imu = next(rings.imu, ahead_[0]);
    const OdometrySample* const odometry = next(rings.odometry, ahead_[1]);
    if (imu != nullptr && (odometry == nullptr || imu->t_us <= odometry->t_us)) {
      take(rings.imu, *imu);
    } else if (odometry != nullptr) {
      take(rings.odometry, *odometry);
    } else {
      break;
    }
  }
  while (const PoseSample* const pose = next(rings.poses, ahead_[2])) take(rings.poses, *pose);
  return taken;
}

void Pipeline::count_outside_motion(std::int64_t oldest_us, std::int64_t known_from_us,
                                    std::int64_t tick_us) noexcept {
  if (known_from_us <= oldest_us) return;
  const EventWindow::Selection all = window_.select(oldest_us, tick_us);
  const EventWindow::Selection inside = window_.select(known_from_us, tick_us);
  const std::uint64_t from = all.first > outside_until_ ? all.first : outside_until_;
  const std::uint64_t until = all.first + all.in_window - inside.in_window;
  if (until > from) {
    window_counters_.outside_motion += until - from;
    outside_until_ = until;
  }
}

void Pipeline::blank(FrameSlot& out) noexcept {
  for (std::uint16_t& v : out.inverse_depth) v = 0;
  for (std::uint8_t& v : out.confidence) v = 0;
}

void Pipeline::conclude(const DepthFrame& frame) noexcept {
  const std::uint32_t flags = frame.flags;
  ++tick_counters_.run;
  if (flags & kNoParallax) ++tick_counters_.no_parallax;
  if (flags & kTooFewEvents) ++tick_counters_.too_few_events;
  if (flags & kStaleVelocity) ++tick_counters_.stale_velocity;
  if (flags & kNoMotion) ++tick_counters_.no_motion;
  const bool carried = (flags & kCarried) != 0;
  if (carried) ++tick_counters_.carried;
  const bool any_event = filter_.counters().kept > 0;
  if (!any_event) {
    state_ = RunState::kWaiting;
    cause_ = Cause::kNoEvents;
  } else if (flags & kNoMotion) {
    state_ = RunState::kStalled;
    cause_ = Cause::kNoMotion;
  } else if (flags & kNoParallax) {
    state_ = carried ? RunState::kDegraded : RunState::kStalled;
    cause_ = Cause::kNoParallax;
  } else if (frame.events == 0 && !carried) {
    state_ = RunState::kStalled;
    cause_ = Cause::kNoEvents;
  } else if (flags & kStaleVelocity) {
    state_ = RunState::kDegraded;
    cause_ = Cause::kStaleVelocity;
  } else if (flags & kTooFewEvents) {
    state_ = RunState::kDegraded;
    cause_ = Cause::kTooFewEvents;
  } else if (flags & kOverload) {
    state_ = RunState::kDegraded;
    cause_ = Cause::kOverload;
  } else {
    state_ = RunState::kRunning;
    cause_ = Cause::kNone;
  }
}

void Pipeline::report(Health& health) const noexcept {
  health.state = state_;
  health.cause = cause_;
  health.events = filter_.counters();
  health.imu = ego_motion_->imu_counters();
  health.odometry = ego_motion_->odometry_counters();
  health.poses = ego_motion_->pose_counters();
  health.imu.invalid += ahead_[0];
  health.odometry.invalid += ahead_[1];
  health.poses.invalid += ahead_[2];
  health.window = window_counters_;
  health.stages = stages_;
  const TickCounters scheduled = health.ticks;
  health.ticks = tick_counters_;
  health.ticks.late = scheduled.late;
  health.ticks.skipped = scheduled.skipped;
}

}  // namespace egofocus
