#include "recorder.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "hal/candump_writer.hpp"
#include "hal/raw_header.hpp"
#include "log.hpp"
#include "recording/error.hpp"
#include "recording/text_file.hpp"

namespace egofocus::daemon {
namespace {

namespace fs = std::filesystem;
using recording::Error;
using recording::ExitCode;

constexpr std::size_t kFrameSlots = 1u << 14;
constexpr std::size_t kEncodedBytes = 1u << 18;
constexpr std::size_t kBatch = 4096;

std::string time_text() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%d-%H%M%S", &utc);
  return text;
}

Descriptor created(const fs::path& path) {
  Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640));
  if (!file.is_open())
    throw Error(ExitCode::kFile, path.string(), std::string("cannot be made (") + std::strerror(errno) + ")");
  return file;
}

}  // namespace

Recorder::Recorder(const RecordConfig& config)
    : config_(config),
      event_slots_(config.folder.empty() ? 64 : config.buffer_events),
      frame_slots_(config.folder.empty() ? 64 : kFrameSlots),
      events_(event_slots_),
      frames_(frame_slots_),
      encoded_(kEncodedBytes) {}

void Recorder::begin(const Setup& setup, std::int64_t now_us) {
  if (config_.folder.empty())
    throw Error(ExitCode::kConfiguration, "[record] folder is empty: name one, and start the daemon again.");
  if (setup.daemon.source.clock != ClockKind::kMonotonic)
    throw Error(ExitCode::kConfiguration, "recordings are made with clock = \"real\" alone.");
  if (setup.camera.config.motion.source == MotionSource::kPoses)
    throw Error(ExitCode::kConfiguration, "the motion are poses, not a bus: there is no can.log to write.");
  Wish wish;
  wish.origin_us = now_us;
  wish.camera_toml = recording::camera_toml_text(setup.camera);
  wish.dbc_name = setup.camera.can.dbc;
  wish.dbc = setup.dbc;
  wish.config = setup.config_text;
  wish.can_interface = setup.daemon.can.interface_name;
  wish.size = {static_cast<std::uint16_t>(setup.camera.config.camera.intrinsics.width_px),
               static_cast<std::uint16_t>(setup.camera.config.camera.intrinsics.height_px)};
  const std::lock_guard lock(guard_);
  if (facts_.on) throw Error(ExitCode::kUsage, "a recording is on already. Stop it first.");
  facts_.on = true;
  facts_.folder.clear();
  facts_.failure.clear();
  facts_.bytes = facts_.not_encodable = 0;
  end_asked_ = false;
  health_lines_.clear();
  wish_ = std::move(wish);
}

bool Recorder::end() {
  const std::lock_guard lock(guard_);
  end_asked_ = facts_.on;
  return facts_.on;
}

void Recorder::note_health(const std::string& line) {
  const std::lock_guard lock(guard_);
  if (facts_.on && health_lines_.size() < kEncodedBytes) health_lines_ += line + "\n";
}

RecorderFacts Recorder::facts() const {
  const std::lock_guard lock(guard_);
  RecorderFacts facts = facts_;
  facts.events_dropped = events_.dropped();
  facts.frames_dropped = frames_.dropped();
  return facts;
}

void Recorder::work() {
  std::optional<Wish> wish;
  std::string lines;
  bool end_asked = false;
  {
    const std::lock_guard lock(guard_);
    wish.swap(wish_);
    lines.swap(health_lines_);
    end_asked = end_asked_;
  }
  try {
    if (wish) open(*wish);
    if (!is_open()) return;
    // What is asked for before this look is whole: the sources stop first, then their rings are emptied.
    if (end_asked) on_.store(false, std::memory_order_release);
    write_events();
    write_frames();
    append(health_file_, lines);
    const bool is_full = bytes_ > static_cast<std::uint64_t>(config_.max_mib) << 20;
    if (is_full) log(Priority::kNotice, folder_.string() + ": the recording ends at [record] max_mib");
    if (end_asked || is_full) close("");
  } catch (const std::exception& error) {
    close(error.what());
  }
  const std::lock_guard lock(guard_);
  facts_.bytes = bytes_;
  facts_.not_encodable = encoder_.counters().not_encodable;
}

void Recorder::open(const Wish& wish) {
  name_folder();
  bytes_ = 0;
  encoder_ = {};
  origin_us_ = wish.origin_us;
  can_interface_ = wish.can_interface;
  std::error_code failure;
  if (!fs::create_directory(partial_, failure))
    throw Error(ExitCode::kFile, partial_.string(), "cannot be made (" + failure.message() + ")");
  recording::write_text_file(partial_ / "camera.toml", wish.camera_toml);
  recording::write_text_file(partial_ / wish.dbc_name, wish.dbc);
  recording::write_text_file(partial_ / "egofocusd.toml", wish.config);
  can_file_ = created(partial_ / "can.log");
  health_file_ = created(partial_ / "health.jsonl");
  events_file_ = created(partial_ / "events.raw");
  RawHeader header;
  header.format = EvtFormat::kEvt3;
  header.size = wish.size;
  std::array<std::byte, kMaxWrittenRawHeaderBytes> text;
  const std::size_t size = write_raw_header(header, text);
  append(events_file_, {reinterpret_cast<const char*>(text.data()), size});
  drop_waiting();
  on_.store(true, std::memory_order_release);
  log(Priority::kNotice, "records to " + folder_.string());
}

void Recorder::name_folder() {
  const fs::path wanted = config_.folder / time_text();
  folder_ = wanted;
  for (int i = 2; fs::exists(folder_) || fs::exists(folder_.string() + ".partial"); ++i)
    folder_ = wanted.string() + "-" + std::to_string(i);
  partial_ = folder_.string() + ".partial";
  const std::lock_guard lock(guard_);
  facts_.folder = folder_.string();
}

void Recorder::drop_waiting() {
  for (auto ready = events_.peek(kBatch); !ready.empty(); ready = events_.peek(kBatch))
    events_.release(ready.size());
  for (auto ready = frames_.peek(kBatch); !ready.empty(); ready = frames_.peek(kBatch))
    frames_.release(ready.size());
}

void Recorder::write_events() {
  std::vector<Event> batch;
  for (auto ready = events_.peek(kBatch); !ready.empty(); ready = events_.peek(kBatch)) {
    batch.assign(ready.begin(), ready.end());
    events_.release(ready.size());
    for (Event& event : batch) event.t_us -= origin_us_;
    std::erase_if(batch, [](const Event& event) { return event.t_us < 0; });
    for (std::span<const Event> left = batch; !left.empty();) {
      const Decoded done = encoder_.encode(left, encoded_);
      append(events_file_, {reinterpret_cast<const char*>(encoded_.data()), done.produced});
      left = left.subspan(done.consumed);
    }
  }
}

void Recorder::write_frames() {
  std::string lines;
  char line[kMaxCandumpLineBytes];
  for (auto ready = frames_.peek(1); !ready.empty(); ready = frames_.peek(1)) {
    CanFrame frame = ready[0];
    frames_.release(1);
    frame.t_us -= origin_us_;
    lines.append(line, write_candump_line(frame, can_interface_, line));
  }
  append(can_file_, lines);
}

void Recorder::append(Descriptor& file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(file.number(), bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0)
      throw Error(ExitCode::kFile, partial_.string(),
                  std::string("cannot be written (") + std::strerror(errno) + ")");
    bytes.remove_prefix(static_cast<std::size_t>(done));
    bytes_ += static_cast<std::uint64_t>(done);
  }
}

void Recorder::close(const std::string& failure) {
  on_.store(false, std::memory_order_release);
  for (Descriptor* file : {&events_file_, &can_file_, &health_file_}) *file = Descriptor();
  std::string what = failure;
  std::error_code refused;
  if (what.empty()) fs::rename(partial_, folder_, refused);
  if (refused) what = partial_.string() + ": cannot be renamed (" + refused.message() + ")";
  if (what.empty()) {
    log(Priority::kNotice, "recorded " + folder_.string() + ", " + std::to_string(bytes_) + " bytes");
  } else {
    log(Priority::kError,
        what + ". The recording ends here; what there is of it stays as " + partial_.string());
  }
  const std::lock_guard lock(guard_);
  facts_.on = false;
  facts_.failure = what;
  end_asked_ = false;
}

}  // namespace egofocus::daemon
