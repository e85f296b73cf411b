/* The C header from C11: the layout that callers rely on, set-up and its failures, samples in, frames and
 * counters out. Prints what is wrong and ends with 1. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "egofocus/egofocus.h"

_Static_assert(sizeof(egofocus_event) == 16, "layout");
_Static_assert(sizeof(egofocus_imu_sample) == 64, "layout");
_Static_assert(sizeof(egofocus_odometry_sample) == 88, "layout");
_Static_assert(sizeof(egofocus_pose_sample) == 64, "layout");
_Static_assert(sizeof(egofocus_intrinsics) == 40, "layout");
_Static_assert(offsetof(egofocus_depth_frame, grid) == 48, "layout");

static int failures = 0;
#define EXPECT(condition)                                              \
  do {                                                                 \
    if (!(condition)) {                                                \
      printf("c_api_test.c:%d: expected: %s\n", __LINE__, #condition); \
      ++failures;                                                      \
    }                                                                  \
  } while (0)

static egofocus_config good_config(void) {
  egofocus_config config;
  memset(&config, 0xff, sizeof config);
  egofocus_config_default(&config);
  config.camera.intrinsics = (egofocus_intrinsics){346, 260, 300.0, 300.0, 172.5, 129.5};
  config.motion.source = EGOFOCUS_MOTION_FROM_POSES;
  config.rings.events = 1u << 14;
  return config;
}

static void test_defaults_and_texts(void) {
  egofocus_config config = good_config();
  EXPECT(config.threads == 1 && config.ladder.hypotheses == 64 && config.rate.rate_hz == 20.0);
  EXPECT(config.carry.max_age_us == 30000000 && config.carry.max_travel == 0.5 &&
         config.carry.min_in_view == 0.1);
  EXPECT(config.motion.camera_from_body[1] == -1.0 && config.filter.hot_pixel_count == 0);
  EXPECT(strncmp(egofocus_version(), "0.", 2) == 0);
  EXPECT(strcmp(egofocus_state_text(EGOFOCUS_RUNNING), "running") == 0);
  egofocus_status status = {1, 2, "memory", EGOFOCUS_ARENA_TOO_SMALL};
  char line[200];
  EXPECT(egofocus_describe(&status, line, sizeof line) == strlen(line) && strstr(line, "2 needed") != NULL);
}

static void test_failures(void) {
  egofocus_config config = good_config();
  egofocus_engine* engine = (egofocus_engine*)&config;
  size_t bytes = 1;
  config.focus.cost = 256 + EGOFOCUS_COST_VARIANCE; /* would be a valid one if cut to 8 bits */
  EXPECT(egofocus_required_bytes(&config, &bytes).code == EGOFOCUS_BAD_FOCUS && bytes == 0);
  config = good_config();
  config.velocity_noise.draw = EGOFOCUS_NOISE_PER_WINDOW + 256;
  EXPECT(egofocus_required_bytes(&config, &bytes).code == EGOFOCUS_BAD_MOTION);
  config = good_config();
  config.velocity_noise.kind = EGOFOCUS_NOISE_DEVIATION;
  config.velocity_noise.percent = 1001;
  EXPECT(egofocus_required_bytes(&config, &bytes).code == EGOFOCUS_BAD_MOTION);
  config = good_config();
  EXPECT(config.velocity_noise.percent == 0.0 && config.velocity_noise.seed == 1);
  config.carry.max_travel = 0;
  EXPECT(egofocus_required_bytes(&config, &bytes).code == EGOFOCUS_BAD_CARRY);
  config = good_config();
  config.camera.intrinsics.fx_px = -1;
  EXPECT(egofocus_required_bytes(&config, &bytes).code == EGOFOCUS_BAD_INTRINSICS);
  config = good_config();
  EXPECT(egofocus_required_bytes(&config, &bytes).code == EGOFOCUS_OK && bytes > 100000);
  char* memory = aligned_alloc(64, (bytes + 127) / 64 * 64);
  egofocus_status status = egofocus_create(&config, memory, bytes - 1, &engine);
  EXPECT(status.code == EGOFOCUS_ARENA_TOO_SMALL && status.value == (int64_t)bytes - 1);
  EXPECT(status.bound == (int64_t)bytes && engine == NULL);
  EXPECT(egofocus_create(&config, memory + 8, bytes, &engine).code == EGOFOCUS_ARENA_MISALIGNED);
  EXPECT(egofocus_create(&config, NULL, bytes, &engine).code == EGOFOCUS_ARENA_TOO_SMALL);
  egofocus_destroy(NULL);
  free(memory);
}

/* A camera that moves sideways at 1 m/s past events that stand still: depth does not matter here, the way
 * does. */
static void push_motion_and_events(egofocus_engine* engine) {
  for (int64_t t = 0; t <= 400000; t += 5000) {
    egofocus_pose_sample pose = {t, {1e-6 * (double)t, 0, 0}, {0, 0, 0, 1}};
    EXPECT(egofocus_push_poses(engine, &pose, 1) == 1);
  }
  static egofocus_event events[8000];
  for (int i = 0; i < 8000; ++i) {
    events[i].t_us = 25 * i;
    events[i].x = (uint16_t)(i * 37 % 346);
    events[i].y = (uint16_t)(i * 53 % 260);
    events[i].polarity = (uint8_t)(i & 1);
  }
  EXPECT(egofocus_push_events(engine, events, 8000) == 8000);
}

static void test_a_run(void) {
  const egofocus_config config = good_config();
  size_t bytes = 0;
  egofocus_engine* engine = NULL;
  EXPECT(egofocus_required_bytes(&config, &bytes).code == EGOFOCUS_OK);
  void* memory = aligned_alloc(64, (bytes + 63) / 64 * 64);
  EXPECT(egofocus_create(&config, memory, bytes, &engine).code == EGOFOCUS_OK);
  if (engine == NULL) {
    free(memory);
    return;
  }
  egofocus_depth_frame frame;
  EXPECT(egofocus_newest(engine, &frame) == 0);
  EXPECT(egofocus_start(engine, 7, 0).code == EGOFOCUS_BAD_STATE);
  EXPECT(egofocus_set_next_tick(engine, 0).code == EGOFOCUS_BAD_STATE);
  EXPECT(egofocus_start(engine, EGOFOCUS_CLOCK_VIRTUAL, 150000).code == EGOFOCUS_OK);
  EXPECT(egofocus_next_tick_us(engine) == 150000);
  push_motion_and_events(engine);
  EXPECT(egofocus_tick(engine) == 1);
  EXPECT(egofocus_newest(engine, &frame) == 1);
  EXPECT(frame.t_us == 150000 && frame.sequence == 0);
  EXPECT(frame.grid.width_px == 346 && frame.grid.height_px == 260 && frame.inverse_depth != NULL);
  EXPECT(frame.events > 0);
  float* depth_m = malloc(346 * 260 * sizeof(float));
  EXPECT(egofocus_metric_depth(&frame, 100.0f, depth_m, 346 * 260) == 346 * 260);
  free(depth_m);
  egofocus_health health;
  egofocus_read_health(engine, &health);
  EXPECT(health.events.in == 8000 && health.poses.used > 0 && health.ticks.run == 1);
  EXPECT(strlen(egofocus_isa(engine)) > 0 && strlen(egofocus_cause_text(health.cause)) > 0);
  EXPECT(egofocus_next_tick_us(engine) == 200000);
  EXPECT(egofocus_set_next_tick(engine, 150000).code == EGOFOCUS_BAD_TICK);
  EXPECT(egofocus_set_next_tick(engine, 163003).code == EGOFOCUS_OK);
  EXPECT(egofocus_next_tick_us(engine) == 163003);
  EXPECT(egofocus_tick(engine) == 1 && egofocus_newest(engine, &frame) == 1);
  EXPECT(frame.t_us == 163003 && frame.sequence == 1);
  egofocus_request_stop(engine);
  EXPECT(egofocus_tick(engine) == 0);
  egofocus_stop(engine);
  egofocus_destroy(engine);
  free(memory);
}

int main(void) {
  test_defaults_and_texts();
  test_failures();
  test_a_run();
  if (failures == 0) puts("c_api_test: ok");
  return failures != 0;
}
