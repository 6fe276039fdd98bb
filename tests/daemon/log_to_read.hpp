// A log whose lines a test can read.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "daemon/log/log.hpp"

namespace dwell::test {

class LogToRead {
 public:
  explicit LogToRead(const std::string& name) : path_(testing::TempDir() + name + std::to_string(getpid()) + ".log") {
    LogOptions to_file;
    to_file.console = false;
    to_file.file = path_;
    log_ = std::move(*Log::make(to_file));
  }
  ~LogToRead() {
    log_.reset();
    std::remove(path_.c_str());
  }
  LogToRead(const LogToRead&) = delete;
  LogToRead& operator=(const LogToRead&) = delete;

  operator Log&() { return *log_; }  // NOLINT(google-explicit-constructor): it is one

  // Ends the log. "warning device a: …": every line without its date.
  std::vector<std::string> lines() {
    log_.reset();
    std::ifstream file(path_);
    std::vector<std::string> out;
    for (std::string line; std::getline(file, line);) out.push_back(line.substr(line.find(' ') + 1));
    return out;
  }

 private:
  std::string path_;
  std::unique_ptr<Log> log_;
};

}  // namespace dwell::test
