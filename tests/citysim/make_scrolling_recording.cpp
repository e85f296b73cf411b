// make_scrolling_recording OUT.raw SEED day|night [NAME=VALUE]...: the sensor over a scrolling texture, for
// `citysim realism`. Names: those of describe(), and speed_px_s, illumination, roughness, width, height,
// seconds.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "citysim/dvs.hpp"
#include "recording/raw_file.hpp"
#include "scrolling_texture.hpp"

using namespace egofocus;
using namespace egofocus::citysim;

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fputs("usage: make_scrolling_recording OUT.raw SEED day|night [NAME=VALUE]...\n", stderr);
    return 2;
  }
  const bool night = std::string(argv[3]) == "night";
  const std::uint64_t seed = std::strtoull(argv[2], nullptr, 10);
  DvsParameters p = draw_dvs_parameters(seed, night);
  ScrollingTexture::Look look;
  look.illumination = night ? 0.03 : 0.7;
  double width = 240, height = 180, seconds = 0.17;
  struct {
    const char* name;
    double* value;
  } const names[] = {{"speed_px_s", &look.speed_px_s},
                     {"illumination", &look.illumination},
                     {"roughness", &look.roughness},
                     {"width", &width},
                     {"height", &height},
                     {"seconds", &seconds},
                     {"threshold_on", &p.threshold_on},
                     {"threshold_off", &p.threshold_off},
                     {"threshold_spread", &p.threshold_spread},
                     {"refractory_us", &p.refractory_us},
                     {"bandwidth_hz", &p.bandwidth_hz},
                     {"bandwidth_floor_hz", &p.bandwidth_floor_hz},
                     {"dark_light", &p.dark_light},
                     {"leak_hz", &p.leak_hz},
                     {"noise_spread", &p.noise_spread},
                     {"shot_noise_hz", &p.shot_noise_hz},
                     {"hot_pixel_share", &p.hot_pixel_share},
                     {"hot_pixel_hz", &p.hot_pixel_hz},
                     {"latency_us", &p.latency_us},
                     {"latency_jitter_us", &p.latency_jitter_us},
                     {"readout_events_per_s", &p.readout_events_per_s}};
  for (int i = 4; i < argc; ++i) {
    const std::string word = argv[i];
    bool known = false;
    for (const auto& name : names) {
      if (word.starts_with(std::string(name.name) + "=")) {
        *name.value = std::atof(word.c_str() + word.find('=') + 1);
        known = true;
      }
    }
    if (!known) {
      std::fprintf(stderr, "make_scrolling_recording: unknown: %s\n", word.c_str());
      return 2;
    }
  }
  const auto w = static_cast<int>(width);
  const auto h = static_cast<int>(height);
  const ScrollingTexture texture(w, h, look, seed);
  Dvs dvs(w, h, p, seed);
  Workers workers(1);
  std::vector<Event> events;
  const double step_s = 0.5 / (1.6 * look.speed_px_s);
  // A sensor that has run for a while: what comes before 0.1 s is left out.
  for (double t_s = 0; t_s < seconds + 0.1; t_s += step_s) {
    const std::vector<float> view = texture.picture(t_s);
    const LightView shown{static_cast<std::int64_t>(t_s * 1e6), view};
    dvs.show({&shown, 1}, workers, events);
  }
  dvs.finish(events);
  std::erase_if(events, [](const Event& event) { return event.t_us < 100'000; });
  for (const NamedValue& value : describe(p))
    std::printf("%s=%g ", std::string(value.name).c_str(), value.value);
  std::puts("");
  recording::write_raw_file(argv[1], events, {static_cast<std::uint16_t>(w), static_cast<std::uint16_t>(h)});
  return 0;
}
