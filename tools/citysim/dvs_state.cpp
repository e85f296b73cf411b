// A sensor's state as bytes: mark, fingerprint of the arguments, scalars, arrays, and a hash over all.
#include "citysim/dvs_state.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace egofocus::citysim {
namespace {

constexpr std::uint64_t kMark = 0x3176'6473'6f66'6765;  // "egofsdv1"

std::uint64_t hash_of(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = bytes.size();
  for (std::size_t i = 0; i < bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min<std::size_t>(8, bytes.size() - i));
    hash = sim::mix_bits(hash ^ word);
  }
  return hash;
}

/// Every scalar, each of eight bytes.
template <typename State, typename Visit>
void each_scalar(State& s, Visit visit) {
  visit(s.start_us);
  visit(s.now_us);
  visit(s.readout.now_us);
  visit(s.readout.busy_ps);
  visit(s.counters.signal_events);
  visit(s.counters.noise_events);
  visit(s.counters.refractory_dropped);
  visit(s.counters.readout_dropped);
}

/// Arrays whose sizes are those of the sensor.
template <typename State, typename Visit>
void each_array(State& s, Visit visit) {
  visit(s.log);
  visit(s.level);
  visit(s.upper);
  visit(s.lower);
  visit(s.blocked_until_us);
  visit(s.last_stamp_us);
  visit(s.latency);
  visit(s.noise.row_clocks);
  visit(s.noise.hot_clocks);
}

/// Events that wait: of any size.
template <typename State, typename Visit>
void each_queue(State& s, Visit visit) {
  visit(s.pending);
  visit(s.served);
}

class Writer {
 public:
  template <typename T>
  void put(const T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* first = reinterpret_cast<const std::uint8_t*>(values);
    bytes.insert(bytes.end(), first, first + count * sizeof(T));
  }
  void put_number(std::uint64_t number) { put(&number, 1); }
  std::vector<std::uint8_t> bytes;
};

[[noreturn]] void refuse(const char* why) {
  throw std::invalid_argument(std::string("Dvs: not a state of this sensor: ") + why);
}

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : left_(bytes) {}
  std::uint64_t number() {
    std::uint64_t value = 0;
    take(&value, 1);
    return value;
  }
  template <typename T>
  void take(T* values, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (count > left_.size() / sizeof(T)) refuse("it is cut off.");
    if (count > 0) std::memcpy(values, left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
  }
  /// Passes over `count` values of `size` bytes.
  void skip(std::uint64_t count, std::size_t size) {
    if (count > left_.size() / size) refuse("it is cut off.");
    left_ = left_.subspan(static_cast<std::size_t>(count) * size);
  }
  [[nodiscard]] bool at_end() const { return left_.empty(); }

 private:
  std::span<const std::uint8_t> left_;
};

}  // namespace

std::vector<std::uint8_t> Dvs::state() const {
  const State& s = *state_;
  Writer out;
  out.put_number(kMark);
  out.put_number(s.fingerprint);
  out.put_number(s.has_view ? 1 : 0);
  each_scalar(s, [&](const auto& value) {
    static_assert(sizeof value == 8);
    out.put(&value, 1);
  });
  const auto put_array = [&](const auto& array) {
    out.put_number(array.size());
    out.put(array.data(), array.size());
  };
  each_array(s, put_array);
  each_queue(s, put_array);
  out.put_number(hash_of(out.bytes));
  return std::move(out.bytes);
}

void Dvs::restore(std::span<const std::uint8_t> state) {
  State& s = *state_;
  if (state.size() < 8) refuse("it is cut off.");
  const auto body = state.first(state.size() - 8);
  if (Reader(state.last(8)).number() != hash_of(body)) refuse("its bytes are damaged.");
  // All is checked in a first pass, so that a refused state changes nothing.
  for (const bool copy : {false, true}) {
    Reader in(body);
    if (in.number() != kMark) refuse("it does not begin like one.");
    if (in.number() != s.fingerprint) refuse("size, parameters or seed differ.");
    const bool has_view = in.number() != 0;
    if (copy) s.has_view = has_view;
    each_scalar(s, [&](auto& value) { copy ? in.take(&value, 1) : in.skip(1, sizeof value); });
    each_array(s, [&](auto& array) {
      if (in.number() != array.size()) refuse("an array has another size.");
      copy ? in.take(array.data(), array.size()) : in.skip(array.size(), sizeof array[0]);
    });
    each_queue(s, [&](auto& queue) {
      const std::uint64_t count = in.number();
      if (!copy) return in.skip(count, sizeof queue[0]);
      queue.resize(static_cast<std::size_t>(count));
      in.take(queue.data(), queue.size());
    });
    if (!in.at_end()) refuse("bytes are left over.");
  }
}

}  // namespace egofocus::citysim
