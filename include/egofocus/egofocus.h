/* egofocus for C and for everything that calls C: the same engine as engine.hpp, plain structs, no global
 * state.
 *
 * Fields, units and ranges are those of the C++ structs of the same name (config.hpp, types.hpp, health.hpp),
 * which say more about each. Times are int64 microseconds; booleans are int32 0 or 1. While the version is
 * 0.x, structs may grow with a minor version; the shared library's soname carries it.
 *
 * Order of calls: egofocus_config_default, set fields, egofocus_required_bytes, egofocus_create,
 * egofocus_start, then push and tick, then egofocus_destroy. After egofocus_start no call allocates, locks or
 * waits without bound. */
#ifndef EGOFOCUS_EGOFOCUS_H
#define EGOFOCUS_EGOFOCUS_H

#include <stddef.h>
#include <stdint.h>

#define EGOFOCUS_C_API __attribute__((visibility("default")))

#ifdef __cplusplus
extern "C" {
#endif

/* --- results -----------------------------------------------------------------------------------------------
 */

typedef enum egofocus_status_code {
  EGOFOCUS_OK = 0,
  EGOFOCUS_ARENA_TOO_SMALL, /* value = bytes given, bound = bytes needed */
  EGOFOCUS_ARENA_MISALIGNED,
  EGOFOCUS_BAD_RESOLUTION,
  EGOFOCUS_BAD_INTRINSICS,
  EGOFOCUS_BAD_DISTORTION,
  EGOFOCUS_BAD_LADDER,
  EGOFOCUS_BAD_RATE,
  EGOFOCUS_BAD_RING,
  EGOFOCUS_BAD_FILTER,
  EGOFOCUS_BAD_WINDOW,
  EGOFOCUS_BAD_FOCUS,
  EGOFOCUS_BAD_MOTION,
  EGOFOCUS_BAD_THREADS,
  EGOFOCUS_TOO_MANY_SOURCES,
  EGOFOCUS_BAD_STATE, /* called in the wrong order; subject says which */
  EGOFOCUS_BAD_HEADER,
  EGOFOCUS_UNSUPPORTED_FORMAT,
  EGOFOCUS_PARSE,
  EGOFOCUS_MISSING_SIGNAL,
  EGOFOCUS_THREAD,   /* value = errno */
  EGOFOCUS_IO,       /* value = errno */
  EGOFOCUS_BAD_TICK, /* value = the time asked for, bound = the one it passed */
  EGOFOCUS_BAD_CARRY,
  EGOFOCUS_BAD_MODEL, /* value = place (byte), bound = what stands there */
  EGOFOCUS_UNSUPPORTED_MODEL,
  EGOFOCUS_MODEL_MISMATCH,   /* value = configured, bound = the model's */
  EGOFOCUS_NO_DEVICE,        /* value = devices of the kind that were found */
  EGOFOCUS_AMBIGUOUS_DEVICE, /* value = how many fit */
  EGOFOCUS_NO_PERMISSION,    /* value = errno */
  EGOFOCUS_DEVICE_BUSY,      /* value = errno */
  EGOFOCUS_UNKNOWN_FIRMWARE, /* value = found, bound = known */
  EGOFOCUS_UNSUPPORTED_DEVICE,
  EGOFOCUS_BAD_DEVICE_SETTING, /* value = as configured */
  EGOFOCUS_DEVICE_LOST         /* value = errno */
} egofocus_status_code;

typedef struct egofocus_status {
  int64_t value;
  int64_t bound;
  const char* subject; /* a static string: the field or step that is meant */
  int32_t code;        /* egofocus_status_code */
} egofocus_status;

/* One line for people: what, where, what to do. Writes at most `size` - 1 characters and a NUL; returns the
 * characters written. Thread: any. RT: yes. */
EGOFOCUS_C_API size_t egofocus_describe(const egofocus_status* status, char* out, size_t size);

/* "0.1.0". Thread: any. RT: yes. */
EGOFOCUS_C_API const char* egofocus_version(void);

/* --- configuration -----------------------------------------------------------------------------------------
 */

typedef struct egofocus_intrinsics {
  int32_t width_px, height_px;
  double fx_px, fy_px, cx_px, cy_px;
} egofocus_intrinsics;

enum { EGOFOCUS_DISTORTION_NONE, EGOFOCUS_DISTORTION_PLUMB_BOB, EGOFOCUS_DISTORTION_EQUIDISTANT };
typedef struct egofocus_camera {
  egofocus_intrinsics intrinsics;
  double coefficients[5]; /* plumb bob: k1 k2 p1 p2 k3; equidistant: k1 k2 k3 k4 */
  int32_t distortion;
} egofocus_camera;

enum { EGOFOCUS_LADDER_PARALLAX, EGOFOCUS_LADDER_METRIC };
typedef struct egofocus_ladder {
  int32_t kind;
  int32_t hypotheses; /* 8..64, a multiple of 8 */
  double z_near_m;
  double span_px;
  double min_parallax_px;
} egofocus_ladder;

typedef struct egofocus_window {
  int32_t max_events, min_events;
  int64_t max_age_us;
} egofocus_window;

typedef struct egofocus_pixel {
  uint16_t x, y;
} egofocus_pixel;

typedef struct egofocus_filter { /* zero switches a stage off */
  int64_t refractory_us;
  int64_t isolated_us;
  int64_t hot_pixel_learn_us;
  int32_t hot_pixel_rate_hz;
  uint32_t hot_pixel_count;
  const egofocus_pixel* hot_pixels; /* read by egofocus_create only; may be NULL when the count is 0 */
} egofocus_filter;

enum { EGOFOCUS_MOTION_FROM_ODOMETRY, EGOFOCUS_MOTION_FROM_POSES };
enum { EGOFOCUS_MOTION_FREE, EGOFOCUS_MOTION_WHEELED };
typedef struct egofocus_motion {
  int32_t source, model;
  double camera_from_body[9]; /* row-major rotation; the default looks along body x */
  double camera_in_body_m[3];
  double gyro_noise_rad_s, gyro_bias_walk_rad_s2, accel_noise_m_s2;
  double wheel_noise_m_s, wheel_scale_error, lateral_noise_m_s;
  double max_speed_m_s, max_rate_rad_s;
  int64_t stale_after_us, max_pose_gap_us;
} egofocus_motion;

enum {
  EGOFOCUS_COST_GRADIENT,
  EGOFOCUS_COST_VARIANCE,
  EGOFOCUS_COST_SOSA,
  EGOFOCUS_COST_SOE,
  EGOFOCUS_COST_STI
};
typedef struct egofocus_focus {
  int32_t cost, support_cells, smoothing, min_support_events;
} egofocus_focus;

typedef struct egofocus_carry { /* depth shown where nothing can be measured: the last measured, moved */
  int64_t max_age_us;           /* 0: nothing is carried */
  double max_travel;            /* 0.01..1 */
  double min_in_view;           /* 0..1 */
  int64_t fuse_us;              /* network: 0..10 s; 0: each tick by itself */
} egofocus_carry;

typedef struct egofocus_rate {
  double rate_hz; /* 0.1..1000 */
  int64_t lateness_us;
  int64_t max_late_us; /* 0: off */
} egofocus_rate;

typedef struct egofocus_rings { /* capacities in samples: powers of two */
  uint32_t events, imu, odometry, poses;
  int32_t max_event_rate_hz; /* more are thinned, evenly; 0: never */
} egofocus_rings;

typedef struct egofocus_real_time {
  int32_t fifo_priority, cpu, lock_memory;
} egofocus_real_time;

enum { EGOFOCUS_NOISE_VARIANCE, EGOFOCUS_NOISE_DEVIATION };
enum { EGOFOCUS_NOISE_PER_SAMPLE, EGOFOCUS_NOISE_PER_WINDOW };
typedef struct egofocus_velocity_noise { /* for experiments; percent 0 is none */
  double percent;                        /* 0..1000 */
  uint64_t seed;
  int32_t kind, draw;
} egofocus_velocity_noise;

enum { EGOFOCUS_BACKEND_FOCUS, EGOFOCUS_BACKEND_NETWORK };
typedef struct egofocus_config {
  egofocus_camera camera;
  egofocus_intrinsics grid; /* working grid; width 0 takes the camera's pinhole part */
  egofocus_ladder ladder;
  egofocus_window window;
  egofocus_filter filter;
  egofocus_motion motion;
  egofocus_focus focus;
  egofocus_carry carry;
  egofocus_rate rate;
  egofocus_rings rings;
  egofocus_real_time real_time;
  egofocus_velocity_noise velocity_noise;
  int32_t backend; /* by default the network where the library has a model embedded */
  int32_t threads; /* 1..8 */
  uint32_t isa_mask;
  const void* model; /* EGOFOCUS_BACKEND_NETWORK: a model file, read by egofocus_required_bytes and
                        egofocus_create only, at a multiple of 16; NULL: the embedded one */
  size_t model_bytes;
} egofocus_config;

/* Sane values for everything but `camera.intrinsics`, which only you know. Thread: any. RT: yes. */
EGOFOCUS_C_API void egofocus_config_default(egofocus_config* config_out);

/* --- samples -----------------------------------------------------------------------------------------------
 */

typedef struct egofocus_event {
  int64_t t_us;
  uint16_t x, y;    /* (0, 0) is the top left pixel */
  uint8_t polarity; /* 1 = ON, 0 = OFF */
  uint8_t reserved[3];
} egofocus_event;

typedef struct egofocus_imu_sample {
  int64_t t_us;
  double gyro_rad_s[3];
  double accel_m_s2[3]; /* specific force: +9.8 along up at rest */
  int32_t has_gyro, has_accel;
} egofocus_imu_sample;

enum { EGOFOCUS_WHEEL_SPEED, EGOFOCUS_BODY_VELOCITY };
typedef struct egofocus_odometry_sample {
  int64_t t_us;
  double velocity_m_s[3];
  double covariance_m2_s2[6]; /* xx xy xz yy yz zz; all zero: the configured default */
  int32_t kind;
  int32_t reserved;
} egofocus_odometry_sample;

typedef struct egofocus_pose_sample {
  int64_t t_us;
  double position_m[3];
  double orientation_xyzw[4];
} egofocus_pose_sample;

/* --- results of a tick -------------------------------------------------------------------------------------
 */

enum { /* bits of egofocus_depth_frame.flags */
       EGOFOCUS_FLAG_NO_PARALLAX = 1,
       EGOFOCUS_FLAG_TOO_FEW_EVENTS = 2,
       EGOFOCUS_FLAG_STALE_VELOCITY = 4,
       EGOFOCUS_FLAG_NO_MOTION = 8,
       EGOFOCUS_FLAG_OVERLOAD = 16,
       EGOFOCUS_FLAG_LATE_TICK = 32,
       EGOFOCUS_FLAG_CARRIED = 64
};
typedef struct egofocus_depth_frame {
  int64_t t_us, age_us, latency_us;
  uint64_t sequence;
  uint64_t votes;
  uint32_t flags;
  uint32_t events;
  egofocus_intrinsics grid;
  double inverse_depth_scale_per_m; /* 1/m = inverse_depth[i] * this; 0 is infinity, or unknown at confidence
                                       0 */
  double parallax_px;
  double velocity_m_s[3], angular_rate_rad_s[3];
  double velocity_sigma_m_s;
  int64_t window_begin_us;
  int32_t hypotheses;
  int32_t reserved;
  const uint16_t* inverse_depth; /* [height * width], row-major; valid until the next egofocus_newest */
  const uint8_t* confidence;     /* the same; 0 = no estimate */
} egofocus_depth_frame;

typedef struct egofocus_event_counters {
  uint64_t in, ring_dropped, over_rate, out_of_range, out_of_order, ahead, late, hot_pixel, refractory,
      isolated, kept;
} egofocus_event_counters;
typedef struct egofocus_sample_counters {
  uint64_t in, ring_dropped, late, invalid, used, rejected;
} egofocus_sample_counters;
typedef struct egofocus_window_counters {
  uint64_t outside_motion, decimated, behind_camera;
} egofocus_window_counters;
typedef struct egofocus_tick_counters {
  uint64_t run, late, skipped, no_parallax, too_few_events, stale_velocity, no_motion, carried;
} egofocus_tick_counters;

typedef struct egofocus_stage_times { /* of the last tick with depth, monotonic clock */
  uint32_t motion_us, warp_us, input_us, backend_us, depth_us, all_us;
} egofocus_stage_times;

enum { EGOFOCUS_WAITING, EGOFOCUS_RUNNING, EGOFOCUS_DEGRADED, EGOFOCUS_STALLED };
typedef struct egofocus_health {
  int32_t state;
  int32_t cause; /* see egofocus_cause_text */
  egofocus_event_counters events;
  egofocus_sample_counters imu, odometry, poses;
  egofocus_window_counters window;
  egofocus_tick_counters ticks;
  egofocus_stage_times stages;
  uint32_t refused;      /* what the system refused at start: 1 priority, 2 memory lock, 4 CPU pin */
  uint32_t sources_lost; /* attached sources whose poll ended with an error */
} egofocus_health;

/* --- the engine --------------------------------------------------------------------------------------------
 */

typedef struct egofocus_engine egofocus_engine; /* lies in the caller's memory */

/* The exact size of the block that egofocus_create needs, or why the configuration cannot be. RT: no. */
EGOFOCUS_C_API egofocus_status egofocus_required_bytes(const egofocus_config* config, size_t* bytes_out);

/* Builds an engine inside `memory`, which starts at a multiple of 64 and outlives it. On failure *engine_out
 * is NULL and the memory is free for other use. RT: no. */
EGOFOCUS_C_API egofocus_status egofocus_create(const egofocus_config* config, void* memory, size_t bytes,
                                               egofocus_engine** engine_out);

/* Stops and ends the engine; NULL is allowed. The memory stays the caller's. RT: no. */
EGOFOCUS_C_API void egofocus_destroy(egofocus_engine* engine);

/* Take what fits, in order; drop and count the rest. Return the number taken.
 * Thread: each kind has one writer at a time. RT: yes. */
EGOFOCUS_C_API size_t egofocus_push_events(egofocus_engine* engine, const egofocus_event* events,
                                           size_t count);
EGOFOCUS_C_API size_t egofocus_push_imu(egofocus_engine* engine, const egofocus_imu_sample* samples,
                                        size_t count);
EGOFOCUS_C_API size_t egofocus_push_odometry(egofocus_engine* engine, const egofocus_odometry_sample* samples,
                                             size_t count);
EGOFOCUS_C_API size_t egofocus_push_poses(egofocus_engine* engine, const egofocus_pose_sample* samples,
                                          size_t count);

enum { EGOFOCUS_CLOCK_VIRTUAL, EGOFOCUS_CLOCK_MONOTONIC };
/* `first_tick_us` is t_0 of the tick grid. RT: no. */
EGOFOCUS_C_API egofocus_status egofocus_start(egofocus_engine* engine, int32_t clock, int64_t first_tick_us);
EGOFOCUS_C_API int64_t egofocus_next_tick_us(const egofocus_engine* engine);
/* EGOFOCUS_CLOCK_VIRTUAL: the next tick is about `t_us`, and the grid goes on from there. EGOFOCUS_BAD_STATE
 * before start, after stop and with the other clock; EGOFOCUS_BAD_TICK when it is not after the last tick, or
 * above 2^60. RT: yes. */
EGOFOCUS_C_API egofocus_status egofocus_set_next_tick(egofocus_engine* engine, int64_t t_us);

/* One step; 1 when a frame was published, 0 at the end or after egofocus_request_stop. RT: yes. */
EGOFOCUS_C_API int32_t egofocus_tick(egofocus_engine* engine);

/* 1 and the newest frame, or 0 before the first. Thread: one reader. RT: yes. */
EGOFOCUS_C_API int32_t egofocus_newest(egofocus_engine* engine, egofocus_depth_frame* frame_out);

/* Metric depth in metres, 0 where unknown, at most `far_m`; returns the values written. Thread: any. RT: yes.
 */
EGOFOCUS_C_API size_t egofocus_metric_depth(const egofocus_depth_frame* frame, float far_m, float* out_m,
                                            size_t count);

/* A snapshot of the counters. Thread: any. RT: yes. */
EGOFOCUS_C_API void egofocus_read_health(const egofocus_engine* engine, egofocus_health* health_out);
/* Static texts. Thread: any. RT: yes. */
EGOFOCUS_C_API const char* egofocus_state_text(int32_t state);
EGOFOCUS_C_API const char* egofocus_cause_text(int32_t cause);
EGOFOCUS_C_API const char* egofocus_isa(const egofocus_engine* engine);

/* Thread: any, and signal handlers. RT: yes. */
EGOFOCUS_C_API void egofocus_request_stop(egofocus_engine* engine);
EGOFOCUS_C_API void egofocus_stop(egofocus_engine* engine);

#ifdef __cplusplus
}
#endif

#endif
