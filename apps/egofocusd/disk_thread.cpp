#include "disk_thread.hpp"

#include <chrono>
#include <exception>
#include <utility>

#include "log.hpp"
#include "recording/text_file.hpp"

namespace egofocus::daemon {
namespace {

constexpr std::chrono::milliseconds kTurn(20);

}  // namespace

DiskThread::DiskThread(std::filesystem::path metrics_file, Recorder& recorder)
    : metrics_file_(std::move(metrics_file)), recorder_(recorder), thread_([this] { work(); }) {}

DiskThread::~DiskThread() {
  {
    const std::lock_guard lock(guard_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void DiskThread::write_metrics(std::string text) {
  const std::lock_guard lock(guard_);
  metrics_ = std::move(text);
}

bool DiskThread::finish(int timeout_ms) {
  recorder_.end();
  std::unique_lock lock(guard_);
  stopping_ = true;
  changed_.notify_all();
  return changed_.wait_for(lock, std::chrono::milliseconds(timeout_ms), [this] { return done_; });
}

void DiskThread::work() {
  for (bool last = false; !last;) {
    std::string text;
    {
      std::unique_lock lock(guard_);
      changed_.wait_for(lock, kTurn, [this] { return stopping_; });
      last = stopping_;
      text.swap(metrics_);
    }
    recorder_.work();
    if (text.empty() || metrics_file_.empty()) continue;
    try {
      recording::write_text_file(metrics_file_, text);
      metrics_failed_ = false;
    } catch (const std::exception& error) {
      if (!std::exchange(metrics_failed_, true)) log(Priority::kWarning, error.what());
    }
  }
  const std::lock_guard lock(guard_);
  done_ = true;
  changed_.notify_all();
}

}  // namespace egofocus::daemon
