// The C header over Engine. The caller's block holds the Engine object first, then the engine's own arena.
#include <new>

#include "egofocus/egofocus.h"
#include "egofocus/engine.hpp"
#include "egofocus/version.hpp"
#include "pipeline/c_convert.hpp"

struct egofocus_engine {
  egofocus::Engine engine;
};

namespace egofocus {
namespace {

constexpr std::size_t kBlockAlignment = 64;
constexpr std::size_t kHandleBytes =
    (sizeof(egofocus_engine) + kBlockAlignment - 1) / kBlockAlignment * kBlockAlignment;

// The C and C++ samples are distinct types: they are converted through a small piece of the stack. Every
// piece is offered, also after one that did not fit, so that the ring counts each dropped sample.
template <typename Sample, typename CSample>
std::size_t push(egofocus_engine& handle, const CSample* samples, std::size_t count) noexcept {
  constexpr std::size_t kPiece = 128;
  Sample piece[kPiece];
  Inlets inlets = handle.engine.inlets();
  std::size_t taken = 0;
  for (std::size_t at = 0; at < count;) {
    const std::size_t n = count - at < kPiece ? count - at : kPiece;
    for (std::size_t i = 0; i < n; ++i) piece[i] = sample_from_c(samples[at + i]);
    taken += inlets.push(std::span<const Sample>(piece, n));
    at += n;
  }
  return taken;
}

static_assert(EGOFOCUS_DEVICE_LOST == static_cast<int>(StatusCode::kDeviceLost),
              "a status code was added on one side only");
static_assert(EGOFOCUS_BAD_STATE == static_cast<int>(StatusCode::kBadState));
static_assert(EGOFOCUS_FLAG_CARRIED == static_cast<int>(kCarried));
static_assert(EGOFOCUS_FLAG_NO_PARALLAX == static_cast<int>(kNoParallax));
static_assert(EGOFOCUS_STALLED == static_cast<int>(RunState::kStalled));
static_assert(EGOFOCUS_BACKEND_NETWORK == static_cast<int>(Backend::kNetwork));
static_assert(EGOFOCUS_COST_STI == static_cast<int>(FocusCost::kSti));
static_assert(EGOFOCUS_CLOCK_MONOTONIC == static_cast<int>(ClockKind::kMonotonic));

}  // namespace
}  // namespace egofocus

using namespace egofocus;

size_t egofocus_describe(const egofocus_status* status, char* out, size_t size) {
  return status_from_c(*status).describe({out, size});
}

const char* egofocus_version(void) {
  return EGOFOCUS_VERSION;
}

void egofocus_config_default(egofocus_config* config_out) {
  *config_out = config_to_c(Config{});
}

egofocus_status egofocus_required_bytes(const egofocus_config* config, size_t* bytes_out) {
  *bytes_out = 0;
  Status status = c_config_problem(*config);
  std::size_t arena_bytes = 0;
  if (status.ok()) status = Engine::required_arena(config_from_c(*config), arena_bytes);
  if (status.ok()) *bytes_out = kHandleBytes + arena_bytes;
  return status_to_c(status);
}

egofocus_status egofocus_create(const egofocus_config* config, void* memory, size_t bytes,
                                egofocus_engine** engine_out) {
  *engine_out = nullptr;
  std::size_t needed = 0;
  const egofocus_status sized = egofocus_required_bytes(config, &needed);
  if (sized.code != EGOFOCUS_OK) return sized;
  if (memory == nullptr || bytes < needed) {
    const std::int64_t given = memory == nullptr ? 0 : static_cast<std::int64_t>(bytes);
    return status_to_c({StatusCode::kArenaTooSmall, "memory", given, static_cast<std::int64_t>(needed)});
  }
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  if (address % kBlockAlignment != 0) {
    return status_to_c(
        {StatusCode::kArenaMisaligned, "memory", static_cast<std::int64_t>(address % kBlockAlignment)});
  }
  auto* handle = new (memory) egofocus_engine;
  std::byte* arena = static_cast<std::byte*>(memory) + kHandleBytes;
  const Status status = handle->engine.configure(config_from_c(*config), {arena, bytes - kHandleBytes});
  if (!status.ok()) {
    handle->~egofocus_engine();
    return status_to_c(status);
  }
  *engine_out = handle;
  return status_to_c({});
}

void egofocus_destroy(egofocus_engine* engine) {
  if (engine == nullptr) return;
  engine->engine.stop();
  engine->~egofocus_engine();
}

size_t egofocus_push_events(egofocus_engine* engine, const egofocus_event* events, size_t count) {
  return push<Event>(*engine, events, count);
}
size_t egofocus_push_imu(egofocus_engine* engine, const egofocus_imu_sample* samples, size_t count) {
  return push<ImuSample>(*engine, samples, count);
}
size_t egofocus_push_odometry(egofocus_engine* engine, const egofocus_odometry_sample* samples,
                              size_t count) {
  return push<OdometrySample>(*engine, samples, count);
}
size_t egofocus_push_poses(egofocus_engine* engine, const egofocus_pose_sample* samples, size_t count) {
  return push<PoseSample>(*engine, samples, count);
}

egofocus_status egofocus_start(egofocus_engine* engine, int32_t clock, int64_t first_tick_us) {
  if (clock != EGOFOCUS_CLOCK_VIRTUAL && clock != EGOFOCUS_CLOCK_MONOTONIC) {
    return status_to_c({StatusCode::kBadState, "clock", clock});
  }
  return status_to_c(engine->engine.start(static_cast<ClockKind>(clock), first_tick_us));
}

int64_t egofocus_next_tick_us(const egofocus_engine* engine) {
  return engine->engine.next_tick_us();
}

egofocus_status egofocus_set_next_tick(egofocus_engine* engine, int64_t t_us) {
  return status_to_c(engine->engine.set_next_tick(t_us));
}

int32_t egofocus_tick(egofocus_engine* engine) {
  return engine->engine.tick() ? 1 : 0;
}

int32_t egofocus_newest(egofocus_engine* engine, egofocus_depth_frame* frame_out) {
  DepthFrame frame;
  if (!engine->engine.newest(frame)) return 0;
  *frame_out = frame_to_c(frame);
  return 1;
}

size_t egofocus_metric_depth(const egofocus_depth_frame* frame, float far_m, float* out_m, size_t count) {
  return metric_depth(pixels_from_c(*frame), far_m, {out_m, count});
}

void egofocus_read_health(const egofocus_engine* engine, egofocus_health* health_out) {
  *health_out = health_to_c(engine->engine.health());
}

const char* egofocus_state_text(int32_t state) {
  return to_string(static_cast<RunState>(state));
}
const char* egofocus_cause_text(int32_t cause) {
  return to_string(static_cast<Cause>(cause));
}
const char* egofocus_isa(const egofocus_engine* engine) {
  return engine->engine.isa();
}

void egofocus_request_stop(egofocus_engine* engine) {
  engine->engine.request_stop();
}
void egofocus_stop(egofocus_engine* engine) {
  engine->engine.stop();
}
