// The part of HDF5's C interface that the export needs, with owners for its identifiers. A failure throws Hdf5Error,
// which hdf5.cpp turns into a message.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace dwell::handon {

struct Hdf5Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Owns an identifier of any kind.
class Hdf5Id {
 public:
  // Throws if `id` is invalid; `what` is the call that failed.
  Hdf5Id(hid_t id, const char* what) : id_(id) {
    if (id < 0) throw Hdf5Error(std::string(what) + " failed");
  }
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  Hdf5Id& operator=(Hdf5Id&&) = delete;
  ~Hdf5Id() {
    if (id_ >= 0) H5Idec_ref(id_);
  }
  [[nodiscard]] hid_t get() const noexcept { return id_; }

 private:
  hid_t id_;
};

inline void hdf5_check(herr_t code, const char* what) {
  if (code < 0) throw Hdf5Error(std::string(what) + " failed");
}

// A new file; replaces one of that name. Does not lock it: OutputFile does.
[[nodiscard]] Hdf5Id hdf5_create(const std::string& path);
[[nodiscard]] Hdf5Id hdf5_group(const Hdf5Id& in, const std::string& name);

void hdf5_attribute(const Hdf5Id& of, const char* name, const std::string& text);  // UTF-8
void hdf5_attribute(const Hdf5Id& of, const char* name, double value);
void hdf5_attribute(const Hdf5Id& of, const char* name, std::int64_t value);

// One text as a dataset of its own.
void hdf5_text(const Hdf5Id& in, const char* name, const std::string& text);

// An empty dataset of one dimension that grows: `chunk` rows are stored together. compressed: shuffle and deflate.
[[nodiscard]] Hdf5Id hdf5_growing(const Hdf5Id& in, const char* name, hid_t type, hsize_t chunk, bool compressed);
// Appends rows to a dataset of `have` rows.
void hdf5_append(const Hdf5Id& dataset, hsize_t have, hsize_t rows, hid_t memory_type, const void* data);
// Opens a dataset without a cache of chunks, since only whole chunks are written.
[[nodiscard]] Hdf5Id hdf5_open(const Hdf5Id& in, const std::string& name);

// Texts of any length, UTF-8.
[[nodiscard]] Hdf5Id hdf5_text_type();

}  // namespace dwell::handon
