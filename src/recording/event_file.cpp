#include "recording/event_file.hpp"

#include <utility>

#include "hal/raw_header.hpp"
#include "recording/error.hpp"

namespace egofocus::recording {
namespace {

constexpr std::size_t kBlockBytes = 1u << 16;

}  // namespace

EventFile::EventFile(std::filesystem::path path, SensorSize size)
    : path_(std::move(path)), file_(path_, std::ios::binary | std::ios::trunc), block_(kBlockBytes) {
  RawHeader header;
  header.format = EvtFormat::kEvt3;
  header.size = size;
  put(write_raw_header(header, block_));
}

void EventFile::write(std::span<const Event> events) {
  while (!events.empty()) {
    const Decoded step = encoder_.encode(events, block_);
    put(step.produced);
    events = events.subspan(step.consumed);
    if ((step.consumed == 0 && step.produced == 0) || encoder_.counters().not_encodable > 0) {
      throw Error(ExitCode::kInternal, path_.string(), "the encoder refuses an event.");
    }
  }
}

void EventFile::close() {
  file_.close();
  put(0);
}

void EventFile::put(std::size_t bytes) {
  if (bytes > 0)
    file_.write(reinterpret_cast<const char*>(block_.data()), static_cast<std::streamsize>(bytes));
  if (!file_)
    throw Error(ExitCode::kFile, path_.string(), "cannot be written. May you write there, is the disk full?");
}

}  // namespace egofocus::recording
