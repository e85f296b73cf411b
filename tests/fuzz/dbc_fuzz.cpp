// Input: 64 bytes of a frame, then the text of a DBC.
#include "fuzz/text_fuzz.hpp"
#include "hal/dbc.hpp"

using namespace egofocus;
using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 64) return 0;
  static Dbc dbc;
  const std::string_view text(reinterpret_cast<const char*>(data) + 64, size - 64);
  const std::string_view wanted[] = {"M", "ARI"};
  (void)read_dbc(text, wanted, dbc).ok();
  const Status status = read_dbc(text, {}, dbc);
  if (!status.ok()) {
    require(dbc.message_count == 0 && dbc.signal_count == 0 && status.value() >= 1);
    return 0;
  }
  require(dbc.message_count <= Dbc::kMaxMessages && dbc.signal_count <= Dbc::kMaxSignals);
  std::size_t signals = 0;
  for (std::size_t m = 0; m < dbc.message_count; ++m) {
    const DbcMessage& message = dbc.messages[m];
    require(dbc.find_message(message.name) == &message && message.first_signal == signals);
    signals += message.signal_count;
    std::uint8_t frame[64];
    std::memcpy(frame, data, sizeof frame);
    const std::span<std::uint8_t> bytes(frame, message.length);
    for (std::size_t s = 0; s < message.signal_count; ++s) {
      const DbcSignal& signal = dbc.signals[message.first_signal + s];
      require(dbc.find_signal(message, signal.name) == &signal);
      (void)is_present(dbc, signal, bytes);
      (void)is_present(dbc, signal, bytes.first(bytes.size() / 2));
      std::uint64_t raw = 0;
      std::uint64_t again = 0;
      double value = 0;
      require(decode_raw(signal, bytes, raw));  // the reader checked that it lies within
      require(decode_signal(signal, bytes, value));
      require(encode_raw(signal, ~raw, bytes) && encode_raw(signal, raw, bytes));
      require(decode_raw(signal, bytes, again) && again == raw);
      require(std::memcmp(frame, data, sizeof frame) == 0);
      (void)encode_signal(signal, value, bytes);
      (void)encode_signal(signal, 1e300, bytes);
      std::memcpy(frame, data, sizeof frame);
    }
  }
  require(signals == dbc.signal_count);
  return 0;
}
