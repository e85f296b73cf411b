#include "device_facts.hpp"

namespace egofocus::daemon {
namespace {

// A camera's stream has one of the two kinds of words; the other's counters are zero.
void tell(const EvtCounters& evt, const InivationCounters& inivation, std::vector<DeviceFact>& out) {
  std::uint64_t violations = 0;
  for (const std::uint64_t kind : evt.violations) violations += kind;
  for (const std::uint64_t kind : inivation.violations) violations += kind;
  out.insert(out.end(), {{"camera_stream_violations", violations},
                         {"camera_stream_events_dropped", evt.dropped_events + inivation.dropped_events},
                         {"camera_sensor_in", evt.sensor_in},
                         {"camera_sensor_out", evt.sensor_out}});
}

}  // namespace

void tell(const UsbCameraCounters& c, std::vector<DeviceFact>& out) {
  out.insert(out.end(), {{"camera_streaming", c.phase == UsbCameraPhase::kStreaming ? 1u : 0u, false},
                         {"camera_events", c.events_pushed},
                         {"camera_events_unmapped", c.events_unmapped},
                         {"camera_device_dropped", c.device_dropped},
                         {"camera_bytes", c.bytes},
                         {"camera_stalls", c.stalls},
                         {"camera_overflows", c.overflows},
                         {"camera_failed_transfers", c.failed},
                         {"camera_clock_restarts", c.clock_restarts},
                         {"camera_opened", c.opened},
                         {"camera_lost", c.lost},
                         {"camera_refused", c.refused}});
  tell(c.evt, c.inivation, out);
}

void tell(const V4l2CameraCounters& c, std::vector<DeviceFact>& out) {
  out.insert(out.end(), {{"camera_streaming", c.is_streaming ? 1u : 0u, false},
                         {"camera_buffers", c.buffers},
                         {"camera_buffers_damaged", c.damaged},
                         {"camera_buffers_wrong", c.wrong},
                         {"camera_buffers_unmarked", c.unmarked_refused + c.unmarked_decoded},
                         {"camera_buffers_lost", c.lost_buffers},
                         {"camera_bytes", c.bytes},
                         {"camera_opened", c.opened},
                         {"camera_lost", c.lost},
                         {"camera_refused", c.refused}});
  tell(c.evt, {}, out);
}

void tell(const SocketCanHealth& c, std::vector<DeviceFact>& out) {
  out.insert(out.end(), {{"can_link_up", c.link == CanLink::kUp ? 1u : 0u, false},
                         {"can_bus_state", static_cast<std::uint64_t>(c.bus), false},
                         {"can_frames", c.frames},
                         {"can_kernel_dropped", c.kernel_dropped},
                         {"can_malformed", c.malformed},
                         {"can_error_frames", c.errors.frames},
                         {"can_controller_overflows", c.errors.rx_overflows},
                         {"can_bus_off", c.errors.bus_off},
                         {"can_restarts", c.restarts},
                         {"can_restarts_refused", c.restarts_refused},
                         {"can_link_downs", c.link_downs},
                         {"can_link_losses", c.link_losses},
                         {"can_samples", c.motion.samples},
                         {"can_samples_invalid", c.motion.samples_invalid},
                         {"can_samples_incomplete", c.motion.samples_incomplete}});
}

}  // namespace egofocus::daemon
