#include "daemon/handon/hdf5_file.hpp"

#include <cstdlib>

namespace dwell::handon {
namespace {

constexpr unsigned kDeflate = 1;  // 9 is five times slower and saves a few percent of noisy readings

Hdf5Id scalar() { return {H5Screate(H5S_SCALAR), "H5Screate"}; }

void write_attribute(const Hdf5Id& of, const char* name, hid_t file_type, hid_t memory_type, const void* value) {
  const Hdf5Id space = scalar();
  const Hdf5Id attribute(H5Acreate2(of.get(), name, file_type, space.get(), H5P_DEFAULT, H5P_DEFAULT), "H5Acreate2");
  hdf5_check(H5Awrite(attribute.get(), memory_type, value), "H5Awrite");
}

// Text for HDF5, where a text ends at the first zero.
const char* up_to_zero(const std::string& text) { return text.c_str(); }

}  // namespace

Hdf5Id hdf5_create(const std::string& path) {
  // Where a file could not be closed, as on a full disk, the library crashes when it tidies up at the program's end.
  (void)H5dont_atexit();
  // OutputFile has locked it, and the library's own lock would be refused.
  ::setenv("HDF5_USE_FILE_LOCKING", "FALSE", 1);
  // We report errors; the library must not print them.
  hdf5_check(H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr), "H5Eset_auto2");
  const Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), "H5Pcreate");
  // Readable by HDF5 1.8 and later.
  hdf5_check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18), "H5Pset_libver_bounds");
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), "H5Fcreate"};
}

Hdf5Id hdf5_group(const Hdf5Id& in, const std::string& name) {
  return {H5Gcreate2(in.get(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), "H5Gcreate2"};
}

Hdf5Id hdf5_text_type() {
  Hdf5Id type(H5Tcopy(H5T_C_S1), "H5Tcopy");
  hdf5_check(H5Tset_size(type.get(), H5T_VARIABLE), "H5Tset_size");
  hdf5_check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "H5Tset_cset");
  return type;
}

void hdf5_attribute(const Hdf5Id& of, const char* name, const std::string& text) {
  const Hdf5Id type = hdf5_text_type();
  const char* value = up_to_zero(text);
  write_attribute(of, name, type.get(), type.get(), static_cast<const void*>(&value));
}

void hdf5_attribute(const Hdf5Id& of, const char* name, double value) {
  write_attribute(of, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void hdf5_attribute(const Hdf5Id& of, const char* name, std::int64_t value) {
  write_attribute(of, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

void hdf5_text(const Hdf5Id& in, const char* name, const std::string& text) {
  const Hdf5Id type = hdf5_text_type();
  const Hdf5Id space = scalar();
  const Hdf5Id dataset(H5Dcreate2(in.get(), name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                       "H5Dcreate2");
  const char* value = up_to_zero(text);
  hdf5_check(H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<const void*>(&value)),
             "H5Dwrite");
}

Hdf5Id hdf5_growing(const Hdf5Id& in, const char* name, hid_t type, hsize_t chunk, bool compressed) {
  const hsize_t none = 0;
  const hsize_t any = H5S_UNLIMITED;
  const Hdf5Id space(H5Screate_simple(1, &none, &any), "H5Screate_simple");
  const Hdf5Id creation(H5Pcreate(H5P_DATASET_CREATE), "H5Pcreate");
  hdf5_check(H5Pset_chunk(creation.get(), 1, &chunk), "H5Pset_chunk");
  if (compressed) {
    hdf5_check(H5Pset_shuffle(creation.get()), "H5Pset_shuffle");
    hdf5_check(H5Pset_deflate(creation.get(), kDeflate), "H5Pset_deflate");
  }
  return {H5Dcreate2(in.get(), name, type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), "H5Dcreate2"};
}

Hdf5Id hdf5_open(const Hdf5Id& in, const std::string& name) {
  const Hdf5Id access(H5Pcreate(H5P_DATASET_ACCESS), "H5Pcreate");
  hdf5_check(H5Pset_chunk_cache(access.get(), 0, 0, 1.0), "H5Pset_chunk_cache");
  return {H5Dopen2(in.get(), name.c_str(), access.get()), "H5Dopen2"};
}

void hdf5_append(const Hdf5Id& dataset, hsize_t have, hsize_t rows, hid_t memory_type, const void* data) {
  if (rows == 0) return;
  const hsize_t total = have + rows;
  hdf5_check(H5Dset_extent(dataset.get(), &total), "H5Dset_extent");
  const Hdf5Id file(H5Dget_space(dataset.get()), "H5Dget_space");
  hdf5_check(H5Sselect_hyperslab(file.get(), H5S_SELECT_SET, &have, nullptr, &rows, nullptr), "H5Sselect_hyperslab");
  const Hdf5Id memory(H5Screate_simple(1, &rows, nullptr), "H5Screate_simple");
  hdf5_check(H5Dwrite(dataset.get(), memory_type, memory.get(), file.get(), H5P_DEFAULT, data), "H5Dwrite");
}

}  // namespace dwell::handon
