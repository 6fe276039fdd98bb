#include "tests/rigsim/options.hpp"

namespace rigsim {

const std::vector<FaultName>& fault_names() {
  static const std::vector<FaultName> names{
      {"noise", &Faults::noise, 1e3, "noise, standard deviation relative to each channel's steady amplitude"},
      {"quantize", &Faults::quantize, 1e3, "quantization step, relative likewise"},
      {"invalid", &Faults::invalid, 1, "probability per reading of no number (NaN; integers: the lowest code)"},
      {"latency", &Faults::latency_s, 60, "the device's turnaround, s"},
      {"latency-jitter", &Faults::latency_jitter_s, 60, "uniform 0 ... this on top of the latency, s"},
      {"exception", &Faults::exception, 1, "probability of exception 4"},
      {"missing", &Faults::missing, 1, "probability of no answer"},
      {"dropout", &Faults::dropout, 1, "probability of falling silent for dropout-length"},
      {"dropout-length", &Faults::dropout_length_s, 3600, "length of a drop-out, s"},
      {"late", &Faults::late, 1, "probability of an answer that comes late-by later"},
      {"late-by", &Faults::late_by_s, 60, "how much later a late answer comes, s"},
      {"short", &Faults::short_frame, 1, "probability of half a frame"},
      {"bad-crc", &Faults::bad_crc, 1, "probability of a wrong CRC (RTU)"},
      {"wrong-id", &Faults::wrong_id, 1, "probability of a wrong transaction id (TCP) or address (RTU)"},
      {"reset", &Faults::reset, 1, "probability of a connection reset (TCP)"},
      {"sync-missing", &Faults::sync_missing, 1, "probability per period of no sync pulse"},
      {"sync-twice", &Faults::sync_twice, 1, "probability per period of two sync pulses"},
      {"babble", &Faults::babble_hz, 1e5, "meaningless frames per second (CAN)"},
  };
  return names;
}

}  // namespace rigsim
