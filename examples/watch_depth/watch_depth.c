/* Prints a line for each depth frame of egofocusd: time, flags, and the nearest depth that is seen well. */
#include <egofocus/depth_reader.h>
#include <stdio.h>
#include <stdlib.h>

static double nearest_m(const egofocus_depth_reader* reader, const egofocus_depth_info* info,
                        const uint16_t* inverse_depth, const uint8_t* confidence) {
  unsigned largest = 0;
  size_t i;
  for (i = 0; i < egofocus_depth_pixels(reader); ++i)
    if (confidence[i] >= 128 && inverse_depth[i] > largest) largest = inverse_depth[i];
  return largest > 0 ? 1.0 / (largest * info->inverse_depth_scale_per_m) : 0;
}

static int fail(const char* what, int result) {
  fprintf(stderr, "watch_depth: %s: %s\n", what, strerror(-result));
  return 3;
}

int main(int argc, char** argv) {
  const char* path = argc > 1 ? argv[1] : "/run/egofocus/depth.sock";
  long frames = argc > 2 ? atol(argv[2]) : -1; /* negative: until the daemon ends */
  egofocus_depth_reader reader;
  egofocus_depth_info info;
  uint16_t* inverse_depth;
  uint8_t* confidence;
  int result = egofocus_depth_open(&reader, path);
  if (result != 0) return fail(path, result);
  inverse_depth = malloc(egofocus_depth_pixels(&reader) * sizeof *inverse_depth);
  confidence = malloc(egofocus_depth_pixels(&reader));
  if (inverse_depth == NULL || confidence == NULL) return fail("frame", -ENOMEM);

  while (frames != 0 && (result = egofocus_depth_wait(&reader, 1000)) >= 0) {
    while (frames != 0 && (result = egofocus_depth_next(&reader, &info, inverse_depth, confidence)) == 1) {
      printf("frame %u t_us %lld events %u flags %u nearest_m %.3f\n", reader.last, (long long)info.t_us,
             info.events, info.flags, nearest_m(&reader, &info, inverse_depth, confidence));
      fflush(stdout);
      --frames;
    }
  }
  if (reader.missed > 0) printf("missed %llu frames\n", (unsigned long long)reader.missed);
  egofocus_depth_close(&reader);
  free(inverse_depth);
  free(confidence);
  return 0;
}
