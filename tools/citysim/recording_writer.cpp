#include "citysim/recording_writer.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

#include "citysim/film.hpp"
#include "citysim/recording_texts.hpp"
#include "hal/evt3_encoder.hpp"
#include "hal/raw_header.hpp"
#include "recording/error.hpp"
#include "recording/folder.hpp"
#include "recording/picture.hpp"
#include "recording/png_io.hpp"
#include "recording/text_file.hpp"

namespace egofocus::citysim {
namespace {

namespace fs = std::filesystem;
using recording::Error;
using recording::ExitCode;

// Work is saved after each piece. Each piece is encoded on its own, so that a resumed file has the same
// bytes.
constexpr int kPieceFrames = 40;
constexpr const char* kSavedName = "resume.bin";

/// What a partial folder is about, and how far it is.
struct Saved {
  char magic[8] = {'c', 'i', 't', 'y', 's', 'i', 'm', '1'};
  std::int32_t family = 0, frames = 0, width_px = 0, height_px = 0, clean = 0, pictures = 0;
  std::uint64_t seed = 0;
  std::int32_t done = 0;  ///< frames
  std::int32_t unused = 0;
  std::uint64_t raw_bytes = 0;  ///< of events.raw
  std::uint64_t events = 0;

  [[nodiscard]] bool same_work(const Saved& other) const {
    return std::memcmp(magic, other.magic, sizeof magic) == 0 && family == other.family &&
           frames == other.frames && width_px == other.width_px && height_px == other.height_px &&
           clean == other.clean && pictures == other.pictures && seed == other.seed;
  }
};

fs::path partial_of(const fs::path& out) {
  fs::path partial = out.has_filename() ? out : out.parent_path();
  partial += ".partial";
  return partial;
}

std::vector<std::byte> encode(std::span<const Event> events) {
  std::vector<std::byte> out;
  std::vector<std::byte> block(1 << 20);
  Evt3Encoder encoder;
  while (!events.empty()) {
    const Decoded done = encoder.encode(events, block);
    out.insert(out.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(done.produced));
    events = events.subspan(done.consumed);
  }
  return out;
}

std::string raw_header(const RecordingOptions& options) {
  RawHeader header;
  header.format = EvtFormat::kEvt3;
  header.size = {static_cast<std::uint16_t>(options.width_px), static_cast<std::uint16_t>(options.height_px)};
  std::byte bytes[kMaxWrittenRawHeaderBytes];
  const std::size_t size = write_raw_header(header, bytes);
  return {reinterpret_cast<const char*>(bytes), size};
}

void append(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::app);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw Error(ExitCode::kFile, path.string(), "cannot be written. Is the disk full?");
}

/// Depth and pictures of the working grid at one time.
class GridCamera {
 public:
  explicit GridCamera(const World& world)
      : world_(world),
        optics_(CameraModel{world.grid, Distortion::kNone, {}}),
        renderer_(world.scene, optics_, world.blur) {}

  void write(const fs::path& folder, std::int64_t t_us, bool pictures) {
    const double t = 1e-6 * static_cast<double>(t_us);
    renderer_.render(world_.camera_at(t).pose, t, scratch_, view_, {.colour = pictures});
    const std::int32_t width = optics_.width();
    const std::int32_t height = optics_.height();
    recording::Grey16Picture depth(width, height);
    for (std::size_t i = 0; i < view_.inverse_depth.size(); ++i) {
      const double rho = static_cast<double>(view_.inverse_depth[i]);
      const double units = rho > 0 ? 1.0 / (rho * world_.depth_scale_m) + 0.5 : 65535.0;
      depth.pixels[i] = static_cast<std::uint16_t>(std::clamp(units, 1.0, 65535.0));
    }
    recording::write_png(folder / recording::depth_name(t_us), depth);
    if (!pictures) return;
    // Exposed for the mean light, with the usual gamma.
    double mean = 0;
    for (const float value : view_.light) mean += static_cast<double>(value);
    mean /= static_cast<double>(view_.light.size());
    const double gain = 0.25 / std::max(mean, 1e-9);
    recording::GreyPicture grey(width, height);
    recording::RgbPicture rgb(width, height);
    for (std::size_t i = 0; i < view_.light.size(); ++i) {
      const Colour& c = view_.colour[i];
      grey.pixels[i] = tone(gain * static_cast<double>(view_.light[i]));
      rgb.pixels[i] = {tone(gain * static_cast<double>(c[0])), tone(gain * static_cast<double>(c[1])),
                       tone(gain * static_cast<double>(c[2]))};
    }
    const std::string name = fs::path(recording::depth_name(t_us)).filename().string();
    recording::write_png(folder / "pictures/grey" / name, grey);
    recording::write_png(folder / "pictures/rgb" / name, rgb);
  }

 private:
  /// Square root twice is close to 1/2.2 for the eye, and the same on every machine.
  static std::uint8_t tone(double light) {
    const double root = square_root(std::clamp(light, 0.0, 1.0));
    return static_cast<std::uint8_t>(255.0 * root + 0.5);
  }

  const World& world_;
  Optics optics_;
  Renderer renderer_;
  RenderScratch scratch_;
  View view_;
};

/// How far the partial folder is; 0 frames when there is none. `state` gets the film's state.
Saved load_saved(const fs::path& partial, const Saved& wanted, std::vector<std::uint8_t>& state) {
  const fs::path path = partial / kSavedName;
  if (!fs::exists(partial)) return wanted;
  std::ifstream file(path, std::ios::binary);
  Saved saved;
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.size() < sizeof saved) {
    throw Error(ExitCode::kUsage, partial.string(),
                "holds the unfinished output of something else. Remove it, or choose another name.");
  }
  std::memcpy(&saved, bytes.data(), sizeof saved);
  if (!saved.same_work(wanted)) {
    throw Error(ExitCode::kUsage, partial.string(),
                "is an unfinished recording with other arguments. Remove it, or choose another name.");
  }
  state.assign(bytes.begin() + sizeof saved, bytes.end());
  return saved;
}

/// Whole or not at all: a kill leaves the old state or the new one.
void save(const fs::path& partial, const Saved& saved, std::span<const std::uint8_t> state) {
  std::string bytes(reinterpret_cast<const char*>(&saved), sizeof saved);
  bytes.append(reinterpret_cast<const char*>(state.data()), state.size());
  recording::write_text_file(partial / kSavedName, bytes);
}

/// A partial folder that nobody can go on with is removed.
class UntilSaved {
 public:
  explicit UntilSaved(fs::path partial) : partial_(std::move(partial)) {}
  ~UntilSaved() {
    std::error_code ignored;
    if (!partial_.empty()) fs::remove_all(partial_, ignored);
  }
  UntilSaved(const UntilSaved&) = delete;
  UntilSaved& operator=(const UntilSaved&) = delete;
  void saved() { partial_.clear(); }

 private:
  fs::path partial_;
};

}  // namespace

RecordingReport write_recording(const RecordingOptions& options, const fs::path& out) {
  if (recording::is_recording(out) || (fs::exists(out) && !fs::is_empty(out))) {
    throw Error(ExitCode::kUsage, out.string(), "is there already. Remove it, or choose another name.");
  }
  const fs::path partial = partial_of(out);
  Saved saved;
  saved.family = static_cast<std::int32_t>(options.family);
  saved.frames = options.frames;
  saved.width_px = options.width_px;
  saved.height_px = options.height_px;
  saved.clean = options.clean_sensor;
  saved.pictures = options.pictures;
  saved.seed = options.seed;
  std::vector<std::uint8_t> state;
  saved = load_saved(partial, saved, state);

  const std::int64_t end_us = kFirstFrameUs + (options.frames - 1) * kFramePeriodUs;
  const double duration_s = 1e-6 * static_cast<double>(end_us) + 0.05;
  const World world = make_world(options.family,
                                 {.width_px = options.width_px,
                                  .height_px = options.height_px,
                                  .duration_s = duration_s,
                                  .clean_sensor = options.clean_sensor,
                                  .library = nullptr},
                                 options.seed);
  Workers workers(options.threads);
  const Optics optics(world.camera);
  Film film(world, optics, workers, options.seed);
  GridCamera grid(world);
  const fs::path raw = partial / "events.raw";
  RecordingReport report;
  report.resumed_at = saved.done;
  if (state.empty()) {
    UntilSaved fresh(partial);
    std::error_code failure;
    fs::create_directories(partial / "depth", failure);
    if (options.pictures && !failure) fs::create_directories(partial / "pictures/grey", failure);
    if (options.pictures && !failure) fs::create_directories(partial / "pictures/rgb", failure);
    if (failure) {
      throw Error(ExitCode::kFile, partial.string(),
                  "cannot be made (" + failure.message() + "). May you write there?");
    }
    const std::string header = raw_header(options);
    recording::write_text_file(raw, header);
    saved.raw_bytes = header.size();
    save(partial, saved, film.state());
    fresh.saved();
  } else {
    film.restore(state);
    fs::resize_file(raw, saved.raw_bytes);
  }

  std::vector<Event> events;
  while (saved.done < options.frames) {
    events.clear();
    const int until = std::min(saved.done + kPieceFrames, options.frames);
    for (int frame = saved.done; frame < until; ++frame) {
      const std::int64_t t_us = kFirstFrameUs + frame * kFramePeriodUs;
      film.run_to(t_us, events);
      grid.write(partial, t_us, options.pictures);
      if (options.progress) options.progress(frame + 1, options.frames);
    }
    if (until == options.frames) film.finish(events);
    const std::vector<std::byte> bytes = encode(events);
    append(raw, bytes);
    saved.done = until;
    saved.raw_bytes += bytes.size();
    saved.events += events.size();
    save(partial, saved, film.state());
  }

  report.events = saved.events;
  report.views = film.counters().views;
  report.wide_steps_share = static_cast<double>(film.counters().wide_steps) /
                            static_cast<double>(std::max<std::uint64_t>(1, report.views));
  report.seconds = duration_s;
  for (const auto& [name, text] : recording_texts(world, options, duration_s)) {
    recording::write_text_file(partial / name, text);
  }
  recording::write_text_file(partial / "citysim.json",
                             recording_facts(world, options, report, film.sensor_counters()));
  fs::remove(partial / kSavedName);
  std::error_code failure;
  fs::rename(partial, out, failure);
  if (failure) throw Error(ExitCode::kFile, out.string(), "cannot be made (" + failure.message() + ").");
  return report;
}

}  // namespace egofocus::citysim
