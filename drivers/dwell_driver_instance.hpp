// The part of dwell_driver.hpp that driver authors need not read: the thread around Driver::run, and the C functions
// that keep every exception on their side. Included by dwell_driver.hpp alone.
#pragma once

#include <pthread.h>

#include <csignal>
#include <exception>
#include <stdexcept>
#include <thread>

#include "dwell_driver.hpp"

namespace dwell::driver {

namespace detail {

// The text of the exception being handled.
inline std::string current_exception_text() noexcept try {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "unknown exception";
  }
} catch (...) {
  return {};
}

inline void tell(char* error, std::size_t error_size, const std::string& text) noexcept {
  if (error == nullptr || error_size == 0) return;
  const std::size_t length = std::min(text.size(), error_size - 1);
  std::memcpy(error, text.data(), length);
  error[length] = '\0';
}

template <class Driver>
class Instance {
 public:
  Instance(const dwell_settings& settings, const dwell_host& host)
      : host_(host), stop_(&host_), name_(settings.device), driver_(Settings(settings), host_) {}
  ~Instance() { stop(); }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  void start() {
    if (thread_.joinable() || stop_.requested()) throw std::runtime_error("already started");
    // Signals belong to the host's own threads.
    sigset_t all{};
    sigset_t before{};
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    try {
      thread_ = std::thread([this] { work(); });
    } catch (...) {
      pthread_sigmask(SIG_SETMASK, &before, nullptr);
      throw;
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    pthread_setname_np(thread_.native_handle(), name_.substr(0, 15).c_str());
  }

  void stop() noexcept {
    stop_.request();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void work() noexcept {
    while (!stop_.requested()) {
      try {
        driver_.run(stop_);
        while (stop_.sleep_for(1'000'000'000)) continue;
      } catch (...) {
        const std::string text = current_exception_text();
        host_.count(DWELL_FAULT_DISCONNECTED);
        host_.state(-1, DWELL_FAULT_DISCONNECTED, text.c_str());
        stop_.sleep_for(1'000'000'000);
      }
    }
  }

  Host host_;
  Stop stop_;
  std::string name_;
  Driver driver_;
  std::thread thread_;
};

template <class Driver>
void check(const dwell_settings* settings, dwell_report report, void* context) {
  try {
    if constexpr (requires(Settings s, Report r) { Driver::check(s, r); }) {
      Report mistakes(report, context);
      Driver::check(Settings(*settings), mistakes);
    }
  } catch (...) {
    report(context, -1, nullptr, current_exception_text().c_str());
  }
}

template <class Driver>
void probe(const dwell_settings* settings, dwell_probed probed, void* context) {
  std::string error = "this driver cannot probe";
  try {
    if constexpr (requires(Settings s, Probed p) { Driver::probe(s, p); }) {
      Probed results(probed, context);
      Driver::probe(Settings(*settings), results);
      return;
    }
  } catch (...) {
    error = current_exception_text();
  }
  for (std::size_t i = 0; i < settings->channel_count; ++i) probed(context, i, 0.0, 0, error.c_str());
}

template <class Driver>
void describe(const dwell_settings* settings, dwell_traits* traits) {
  try {
    dwell_traits known{};
    known.size = traits->size;
    Driver::describe(Settings(*settings), known);
    std::memcpy(traits, &known, std::min<std::size_t>(traits->size, sizeof known));
  } catch (...) {  // NOLINT(bugprone-empty-catch): then nothing is known
  }
}

template <class Driver>
void* create(const dwell_settings* settings, const dwell_host* host, char* error, std::size_t error_size) {
  try {
    return new Instance<Driver>(*settings, *host);
  } catch (...) {
    tell(error, error_size, current_exception_text());
    return nullptr;
  }
}

template <class Driver>
std::int32_t start(void* instance, char* error, std::size_t error_size) {
  try {
    static_cast<Instance<Driver>*>(instance)->start();
    return 0;
  } catch (...) {
    tell(error, error_size, current_exception_text());
    return 1;
  }
}

template <class Driver>
void stop(void* instance) {
  static_cast<Instance<Driver>*>(instance)->stop();
}

template <class Driver>
void destroy(void* instance) {
  delete static_cast<Instance<Driver>*>(instance);
}

}  // namespace detail

template <class Driver>
constexpr dwell_driver_table make_table(const char* name, const char* version, const char* help,
                                        std::span<const dwell_key> keys) {
  return {sizeof(dwell_driver_table),
          DWELL_DRIVER_ABI,
          name,
          version,
          help,
          keys.data(),
          keys.size(),
          sizeof(dwell_key),
          &detail::check<Driver>,
          &detail::probe<Driver>,
          &detail::create<Driver>,
          &detail::start<Driver>,
          &detail::stop<Driver>,
          &detail::destroy<Driver>,
          &detail::describe<Driver>};
}

}  // namespace dwell::driver
