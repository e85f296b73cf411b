// The one thread that touches the disk while the daemon runs: metrics and recordings. A disk that hangs stops
// nothing else.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

#include "recorder.hpp"

namespace egofocus::daemon {

class DiskThread {
 public:
  /// An empty `metrics_file`: none is written.
  DiskThread(std::filesystem::path metrics_file, Recorder& recorder);
  ~DiskThread();

  /// Replaces the metrics file, soon; the newest text counts. Thread: the service's.
  void write_metrics(std::string text);

  /// Ends a recording and the thread. False: the disk did not answer in time, and the thread goes on.
  bool finish(int timeout_ms);

 private:
  void work();

  std::filesystem::path metrics_file_;
  Recorder& recorder_;
  std::mutex guard_;
  std::condition_variable changed_;
  std::string metrics_;
  bool stopping_ = false;
  bool done_ = false;
  bool metrics_failed_ = false;
  std::thread thread_;
};

}  // namespace egofocus::daemon
