#include "daemon/handon/hdf5.hpp"

#include <algorithm>
#include <set>
#include <vector>

#include "config/units.hpp"
#include "daemon/handon/hdf5_file.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/report/dwell_json.hpp"

namespace dwell::handon {
namespace {

constexpr std::size_t kBytesPerSample = 8 + 8 + 8 + 4 + 1;
constexpr std::size_t kChunkBytes = 48U << 20U;  // bytes, of all channels together
constexpr std::size_t kMostRows = 16384;         // of a chunk: larger ones compress no better
constexpr std::size_t kFewestRows = 16;

// Rows kept per channel until a chunk is full.
std::size_t rows_of(std::size_t channels) {
  return std::clamp(kChunkBytes / kBytesPerSample / std::max<std::size_t>(channels, 1), kFewestRows, kMostRows);
}

struct Columns {
  std::vector<std::int64_t> t_ns;
  std::vector<double> value, raw;
  std::vector<std::uint32_t> t_half_ns;
  std::vector<std::uint8_t> flags;
  hsize_t written = 0;
};

// The name of a channel's group, without "/", which separates groups in HDF5.
std::string group_name(std::string name, std::set<std::string>& taken) {
  std::replace(name.begin(), name.end(), '/', '_');
  if (name == "." || name == "..") name += "_";
  while (!taken.insert(name).second) name += "_";
  return name;
}

void describe(const Hdf5Id& group, const Channel& c, Motion motion) {
  hdf5_attribute(group, "name", c.name);
  hdf5_attribute(group, "unit", c.unit);
  hdf5_attribute(group, "si_unit", std::string(config::si_unit(c.measures, motion)));
  hdf5_attribute(group, "si_per_unit", c.si_per_unit);
  hdf5_attribute(group, "scale", c.scale);
  hdf5_attribute(group, "offset", c.offset);
  if (c.stated.scale_u) hdf5_attribute(group, "scale_u", c.scale_u);  // absent: not stated, which is not 0
  hdf5_attribute(group, "delay_s", c.delay_s);
  hdf5_attribute(group, "measures", std::string(config::to_string(c.measures)));
  hdf5_attribute(group, "at", place_text(c.at));
  if (c.relative_to) hdf5_attribute(group, "relative_to", place_text(*c.relative_to));
  if (!c.calibration.id.empty()) hdf5_attribute(group, "calibration_id", c.calibration.id);
  if (!c.calibration.due.empty()) hdf5_attribute(group, "calibration_due", c.calibration.due);
  if (c.measures == Quantity::force)
    hdf5_attribute(group, "positive", std::string(c.force_on_mass ? "mass" : "ground"));
}

void describe(const Hdf5Id& file, const Selection& selection, const Provenance& provenance) {
  const record::RunHeader& run = selection.header();
  const auto text = [&file](const char* name, const std::string& value) { hdf5_attribute(file, name, value); };
  text("format", "dwell run 1");
  hdf5_attribute(file, "run", run.run);
  text("id", run.id);
  text("label", run.label);
  text("comment", run.comment);
  text("rig", selection.rig().name);
  text("rig_sha256", run.rig.sha256);
  text("begun_by", run.begun_by);
  text("operator", run.person ? run.person->name : std::string());
  text("start_utc", run.start_utc);
  text("time_zone", run.origin.time_zone);
  text("clock", clock_text(run.origin));
  text("host", run.origin.host);
  text("recorded_with", run.origin.version);
  text("ended", selection.end() ? selection.end()->why : std::string());
  hdf5_attribute(file, "zero_ns", selection.zero_ns());
  if (selection.from_ns() != INT64_MIN) hdf5_attribute(file, "from_ns", selection.from_ns() - selection.zero_ns());
  if (selection.to_ns() != INT64_MAX) hdf5_attribute(file, "to_ns", selection.to_ns() - selection.zero_ns());
  if (!provenance.head.empty()) text("head", provenance.head);  // absent: not checked
  text("audit", provenance.audit);
  text("made_by", provenance.program);
  text("made_utc", provenance.made_utc);
}

// Writes the samples of all channels, a chunk of one channel at a time.
class ChannelWriter {
 public:
  ChannelWriter(const Hdf5Id& file, const Rig& rig)
      : rig_(rig), rows_(rows_of(rig.channels.size())), columns_(rig.channels.size()) {
    const Hdf5Id channels = hdf5_group(file, "channels");
    std::set<std::string> taken;
    for (const Channel& channel : rig.channels) {
      names_.push_back(group_name(channel.name, taken));
      const Hdf5Id group = hdf5_group(channels, names_.back());
      describe(group, channel, rig.motion);
      make(group, "t_ns", H5T_STD_I64LE, "ns");
      make(group, "value", H5T_IEEE_F64LE, channel.unit);
      make(group, "raw", H5T_IEEE_F64LE, "");
      make(group, "t_half_ns", H5T_STD_U32LE, "ns");
      make(group, "flags", H5T_STD_U8LE, "");
    }
  }

  void take(const Hdf5Id& file, const Record& record, std::int64_t zero_ns) {
    Columns& c = columns_[record.channel];
    c.t_ns.push_back(record.t_ns - zero_ns);
    c.value.push_back(in_unit(rig_.channels[record.channel], record.value));
    c.raw.push_back(record.value);
    c.t_half_ns.push_back(record.t_half_ns);
    c.flags.push_back(record.flags);
    if (c.t_ns.size() == rows_) flush(file, record.channel);
  }

  void finish(const Hdf5Id& file) {
    for (std::size_t channel = 0; channel < columns_.size(); ++channel) flush(file, channel);
  }

 private:
  void make(const Hdf5Id& group, const char* name, hid_t type, const std::string& unit) const {
    const Hdf5Id dataset = hdf5_growing(group, name, type, rows_, true);
    hdf5_attribute(dataset, "unit", unit);
  }

  template <class T>
  void append(const Hdf5Id& group, const char* name, hid_t type, hsize_t have, std::vector<T>& values) const {
    hdf5_append(hdf5_open(group, name), have, values.size(), type, values.data());
    values.clear();
  }

  void flush(const Hdf5Id& file, std::size_t channel) {
    Columns& c = columns_[channel];
    const hsize_t rows = c.t_ns.size();
    if (rows == 0) return;
    const Hdf5Id group(H5Gopen2(file.get(), ("channels/" + names_[channel]).c_str(), H5P_DEFAULT), "H5Gopen2");
    append(group, "t_ns", H5T_NATIVE_INT64, c.written, c.t_ns);
    append(group, "value", H5T_NATIVE_DOUBLE, c.written, c.value);
    append(group, "raw", H5T_NATIVE_DOUBLE, c.written, c.raw);
    append(group, "t_half_ns", H5T_NATIVE_UINT32, c.written, c.t_half_ns);
    append(group, "flags", H5T_NATIVE_UINT8, c.written, c.flags);
    c.written += rows;
  }

  const Rig& rig_;
  std::size_t rows_;
  std::vector<Columns> columns_;
  std::vector<std::string> names_;
};

// A growing dataset of texts, one row at a time.
class TextRows {
 public:
  TextRows(const Hdf5Id& file, const char* name)
      : type_(hdf5_text_type()), dataset_(hdf5_growing(file, name, type_.get(), 64, false)) {}
  void add(const std::string& text) {
    const char* row = text.c_str();
    hdf5_append(dataset_, count_++, 1, type_.get(), static_cast<const void*>(&row));
  }

 private:
  Hdf5Id type_, dataset_;
  hsize_t count_ = 0;
};

Result<void> write_texts(const Hdf5Id& file, Selection& selection) {
  hdf5_text(file, "rig_file", selection.header().rig.text);
  TextRows results(file, "results"), events(file, "events");
  auto done = selection.reader().dwells([&](const record::StoredResult& result) {
    const auto view = parse_dwell(result.dwell);
    if (!result.final && !(view && view->dwell.index)) return true;  // between two dwells
    if (!view || selection.overlaps(view->dwell.start_s, view->dwell.end_s)) results.add(result.dwell);
    return true;
  });
  if (!done) return done;
  return selection.reader().events([&](const record::StoredEvent& event) {
    events.add(to_json(event));
    return true;
  });
}

Result<std::uint64_t> write_all(Selection& selection, const Provenance& provenance, const std::string& path,
                                const Progress& progress) {
  const Hdf5Id file = hdf5_create(path);
  describe(file, selection, provenance);
  ChannelWriter channels(file, selection.rig());
  std::uint64_t count = 0;
  auto done = selection.samples(
      [&](const Record& record) {
        channels.take(file, record, selection.zero_ns());
        ++count;
        return true;
      },
      progress);
  if (!done) return tl::make_unexpected(done.error());
  channels.finish(file);
  if (done = write_texts(file, selection); !done) return tl::make_unexpected(done.error());
  hdf5_check(H5Fflush(file.get(), H5F_SCOPE_GLOBAL), "H5Fflush");
  return count;
}

}  // namespace

Result<std::uint64_t> export_hdf5(Selection& selection, const Provenance& provenance, const Target& target,
                                  const Progress& progress) {
  auto file = OutputFile::create(target);  // its message says more than the library's
  if (!file) return tl::make_unexpected(file.error());
  try {
    auto count = write_all(selection, provenance, file->part(), progress);
    if (!count) return count;
    if (auto done = file->keep(); !done) return tl::make_unexpected(done.error());
    return count;
  } catch (const Hdf5Error& error) {
    return tl::make_unexpected(target.path + ": HDF5 cannot write it: " + error.what() +
                               "; is there room on the disk?");
  }
}

}  // namespace dwell::handon
