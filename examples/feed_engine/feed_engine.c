/* The engine inside a C program: events and poses in, depth out. Here both are made up: a camera that slides
 * along a wall 2 m away at 1 m/s. In yours they come from a camera and a robot; everything else is the same.
 */
#include <egofocus/egofocus.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 160, HEIGHT = 120, EVENTS_PER_MS = 20, TICKS = 20 };
static const double FOCAL_PX = 120.0, WALL_M = 2.0, SPEED_M_S = 1.0;

/* Events and poses of one millisecond. A point of the wall crosses the image at FOCAL_PX * SPEED_M_S / WALL_M
 * px/s; each event is one point's. */
static void feed(egofocus_engine* engine, int64_t t_us) {
  egofocus_event events[EVENTS_PER_MS];
  egofocus_pose_sample pose = {t_us, {SPEED_M_S * (double)t_us * 1e-6, 0, 0}, {0, 0, 0, 1}};
  double shift_px = FOCAL_PX * SPEED_M_S / WALL_M * (double)t_us * 1e-6;
  int i;
  for (i = 0; i < EVENTS_PER_MS; ++i) {
    uint32_t point = (uint32_t)rand() % 400; /* of 400 on the wall, always the same ones */
    double x = (double)(point * 2654435761u % WIDTH) - shift_px;
    while (x < 0) x += WIDTH; /* what leaves the image comes back on the other side */
    events[i] = (egofocus_event){t_us, (uint16_t)x, (uint16_t)(point * 40503u / 7 % HEIGHT), 1, {0, 0, 0}};
  }
  egofocus_push_events(engine, events, EVENTS_PER_MS);
  egofocus_push_poses(engine, &pose, 1);
}

static int by_value(const void* a, const void* b) {
  float x = *(const float*)a, y = *(const float*)b;
  return (x > y) - (x < y);
}

/* The middle one of all depths that are known; 0 without any. */
static double median_m(const egofocus_depth_frame* frame) {
  static float depth_m[WIDTH * HEIGHT];
  size_t count = egofocus_metric_depth(frame, 100.0f, depth_m, WIDTH * HEIGHT), known = 0, i;
  for (i = 0; i < count; ++i)
    if (depth_m[i] > 0) depth_m[known++] = depth_m[i];
  if (known == 0) return 0;
  qsort(depth_m, known, sizeof depth_m[0], by_value);
  return depth_m[known / 2];
}

static int fail(const char* what, const egofocus_status* status) {
  char line[200];
  egofocus_describe(status, line, sizeof line);
  fprintf(stderr, "feed_engine: %s: %s\n", what, line);
  return 1;
}

int main(void) {
  egofocus_config config;
  egofocus_status status;
  egofocus_engine* engine;
  egofocus_depth_frame frame;
  egofocus_health health;
  size_t bytes;
  void* memory;
  int64_t t_us = 0;
  int i;

  egofocus_config_default(&config);
  config.camera.intrinsics = (egofocus_intrinsics){WIDTH, HEIGHT, FOCAL_PX, FOCAL_PX, WIDTH / 2, HEIGHT / 2};
  config.backend = EGOFOCUS_BACKEND_FOCUS;
  config.ladder.z_near_m = 1.0;
  config.motion.source = EGOFOCUS_MOTION_FROM_POSES;
  status = egofocus_required_bytes(&config, &bytes);
  if (status.code != EGOFOCUS_OK) return fail("configuration", &status);

  memory = aligned_alloc(64, (bytes + 63) / 64 * 64); /* all that the engine will ever use */
  if (memory == NULL) return fprintf(stderr, "feed_engine: no memory\n"), 1;
  status = egofocus_create(&config, memory, bytes, &engine);
  if (status.code != EGOFOCUS_OK) return fail("engine", &status);
  status = egofocus_start(engine, EGOFOCUS_CLOCK_VIRTUAL, 50000);
  if (status.code != EGOFOCUS_OK) return fail("start", &status);

  for (i = 0; i < TICKS; ++i) {
    while (t_us < egofocus_next_tick_us(engine)) feed(engine, t_us += 1000);
    if (egofocus_tick(engine) != 1 || egofocus_newest(engine, &frame) != 1) break;
    printf("tick at %lld us: %u events, flags %u, median depth %.2f m\n", (long long)frame.t_us, frame.events,
           frame.flags, median_m(&frame));
  }
  egofocus_read_health(engine, &health);
  printf("%s, %llu events dropped\n", egofocus_state_text(health.state),
         (unsigned long long)health.events.ring_dropped);
  egofocus_destroy(engine);
  free(memory);
  return 0;
}
