// A spdlog sink that hands each line to journald with its priority and fields.
#pragma once

#include <spdlog/sinks/base_sink.h>

namespace dwell {

// Written by the log's one thread alone.
class JournalSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 private:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}
};

}  // namespace dwell
