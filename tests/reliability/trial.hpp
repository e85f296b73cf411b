// One fault done to one robot: what was lost, how long until depth was good again, and what must hold of all.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "recording/json.hpp"
#include "robot.hpp"

namespace egofocus::reliability {

/// A row of the table. It passes when `complaints` is empty.
struct Row {
  std::string fault;
  std::string made;                           ///< how
  std::map<std::string, std::uint64_t> lost;  ///< counters of loss that went up
  double good_after_s = 0;  ///< from the fault's end to the first frame from which all are good
  double rss_percent = 0;   ///< change of resident memory
  std::uint32_t flags = 0;  ///< of frames from the fault's begin to good depth
  std::string remark;
  std::vector<std::string> complaints;

  [[nodiscard]] recording::Json json() const;
};

/// begin -> what is done to `robot` -> over() -> row(). The robot has good depth when it begins.
class Trial {
 public:
  Trial(std::string fault, std::string made, Robot& trial_robot);

  /// The fault's cause is gone.
  void over();
  /// Waits until depth is good for a second, at most `patience_us`, and holds the whole against what must be
  /// true of every fault: nothing is lost uncounted, no poor frame is without a flag, memory stays as it is.
  [[nodiscard]] Row row(std::int64_t patience_us = 10'000'000);

  /// Something that must be true of this fault alone.
  void expect(bool is_true, const std::string& what);
  void remark(const std::string& text) { row_.remark += (row_.remark.empty() ? "" : "; ") + text; }
  /// How much a counter went up since the beginning.
  [[nodiscard]] std::uint64_t up(const std::string& counter) const;
  /// Frames since the beginning.
  [[nodiscard]] const Seen& seen();

 private:
  Robot& robot_;
  Row row_;
  std::map<std::string, std::uint64_t> before_;
  std::uint64_t sent_before_ = 0;
  std::uint64_t unseen_before_ = 0;
  std::int64_t rss_before_ = 0;
  Seen seen_;
  std::int64_t over_us_ = 0;
};

struct Fault {
  const char* name;
  Row (*run)();
};
std::vector<Fault> camera_faults();
std::vector<Fault> load_faults();
std::vector<Fault> motion_faults();

}  // namespace egofocus::reliability
