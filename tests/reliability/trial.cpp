#include "trial.hpp"

#include <algorithm>
#include <cstdio>

#include "resident_memory.hpp"

namespace egofocus::reliability {
namespace {

constexpr std::int64_t kWarmUp_us = 6'000'000;  // masks, clocks and biases have settled
constexpr std::int64_t kGoodFor_us = 1'000'000;
constexpr double kMostGrowth_percent = 1;

constexpr const char* kLosses[] = {"camera_lost",
                                   "camera_refused",
                                   "camera_stalls",
                                   "camera_overflows",
                                   "camera_failed_transfers",
                                   "camera_clock_restarts",
                                   "camera_events_unmapped",
                                   "camera_stream_violations",
                                   "camera_stream_events_dropped",
                                   "events_ring_dropped",
                                   "events_over_rate",
                                   "events_out_of_range",
                                   "events_out_of_order",
                                   "events_ahead",
                                   "events_late",
                                   "events_hot_pixel",
                                   "window_decimated",
                                   "can_link_downs",
                                   "can_link_losses",
                                   "can_bus_off",
                                   "can_restarts",
                                   "can_kernel_dropped",
                                   "can_malformed",
                                   "odometry_rejected",
                                   "ticks_skipped"};

void add(Seen& all, const Seen& some) {
  all.ticks += some.ticks;
  all.good += some.good;
  all.flags |= some.flags;
  all.poor_unflagged += some.poor_unflagged;
  all.worst_unflagged = std::max(all.worst_unflagged, some.worst_unflagged);
  all.not_good_us = std::max(all.not_good_us, some.not_good_us);
  all.clock_error_us = std::max(all.clock_error_us, some.clock_error_us);
}

}  // namespace

recording::Json Row::json() const {
  recording::Json lost_json;
  for (const auto& [name, count] : lost) lost_json.add(name, count);
  recording::Json out;
  out.add("fault", fault).add("made", made).add("lost", lost_json);
  out.add("good_after_s", good_after_s).add("rss_percent", rss_percent).add("flags", flags);
  out.add("remark", remark);
  std::string all;
  for (const std::string& complaint : complaints) all += (all.empty() ? "" : "; ") + complaint;
  return out.add("complaints", all);
}

Trial::Trial(std::string fault, std::string made, Robot& trial_robot) : robot_(trial_robot) {
  row_.fault = std::move(fault);
  row_.made = std::move(made);
  // A loss and a flood before: all memory that they take has been taken, and all code has been there.
  robot_.run(kWarmUp_us);
  robot_.trouble.event_copies = 5;
  robot_.camera().is_plugged = false;
  robot_.run(kGoodFor_us);
  robot_.camera().is_plugged = true;
  robot_.run(2 * kGoodFor_us);
  robot_.trouble = {};
  robot_.run(kWarmUp_us);
  static_cast<void>(robot_.look());
  robot_.run(kGoodFor_us);
  const Seen seen = robot_.look();
  expect(seen.ticks > 0 && seen.good == seen.ticks, "depth was not good before the fault");
  before_ = robot_.counters();
  sent_before_ = robot_.events_sent_at_tick;
  unseen_before_ = robot_.events_unseen;
  rss_before_ = resident_bytes();
}

void Trial::expect(bool is_true, const std::string& what) {
  if (!is_true) row_.complaints.push_back(what);
}

std::uint64_t Trial::up(const std::string& counter) const {
  return robot_.counters().at(counter) - before_.at(counter);
}

const Seen& Trial::seen() {
  add(seen_, robot_.look());
  return seen_;
}

void Trial::over() {
  static_cast<void>(seen());
  over_us_ = robot_.now_us();
}

Row Trial::row(std::int64_t patience_us) {
  bool is_good = false;
  Seen after;
  while (!is_good && robot_.now_us() - over_us_ < patience_us) {
    robot_.run(Robot::kStep_us);
    add(after, robot_.look());
    const std::int64_t since_us = std::max(over_us_, after.not_good_us);
    is_good = after.ticks > 0 && robot_.now_us() - since_us >= kGoodFor_us;
  }
  expect(is_good, "depth was not good again");
  row_.good_after_s = after.not_good_us == 0 ? 0 : static_cast<double>(after.not_good_us - over_us_) * 1e-6;
  add(seen_, after);
  row_.flags = seen_.flags;
  expect(seen_.poor_unflagged == 0, std::to_string(seen_.poor_unflagged) +
                                        " poor frames without a flag, the worst " +
                                        std::to_string(seen_.worst_unflagged) + " off");

  const auto now = robot_.counters();
  for (const char* name : kLosses)
    if (const std::uint64_t more = now.at(name) - before_.at(name); more > 0) row_.lost[name] = more;
  if (const std::uint64_t unseen = robot_.events_unseen - unseen_before_; unseen > 0)
    row_.lost["events that no transfer brought"] = unseen;
  // What came to the host is offered to the engine, or counted as dropped on the way.
  const std::uint64_t sent = robot_.events_sent_at_tick - sent_before_;
  const std::uint64_t told =
      up("events_in") + up("camera_events_unmapped") + up("camera_stream_events_dropped");
  if (robot_.trouble.corrupt_words == 0 && row_.lost.count("camera_stream_violations") == 0)
    expect(sent == told, std::to_string(sent) + " events sent, " + std::to_string(told) + " accounted for");
  // And what was offered is in one line of the engine's, but for the newest, which still wait.
  std::uint64_t lines = 0;
  for (const char* name : {"events_ring_dropped", "events_over_rate", "events_out_of_range",
                           "events_out_of_order", "events_ahead", "events_late", "events_hot_pixel",
                           "events_refractory", "events_isolated", "events_kept"})
    lines += now.at(name);
  const std::uint64_t in = now.at("events_in");
  expect(lines <= in && in - lines < 10'000,
         std::to_string(in) + " events in, " + std::to_string(lines) + " in a line");

  row_.rss_percent =
      100.0 * static_cast<double>(resident_bytes() - rss_before_) / static_cast<double>(rss_before_);
  if (EGOFOCUS_RESIDENT_MEMORY_IS_OURS)
    expect(row_.rss_percent < kMostGrowth_percent,
           "memory grew by " + std::to_string(row_.rss_percent) + " %");
  return row_;
}

}  // namespace egofocus::reliability
