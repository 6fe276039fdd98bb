# Writes OUTPUT, a header with the SHA-256 that tells programs of different sources apart. From a checkout:
#   find core config daemon drivers -name '*.[ch]pp' | LC_ALL=C sort | xargs sha256sum | sha256sum
# cmake -DROOT=... -DOUTPUT=... -P sources.cmake
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/core/*.?pp ${ROOT}/config/*.?pp ${ROOT}/daemon/*.?pp ${ROOT}/drivers/*.?pp)
list(FILTER sources INCLUDE REGEX "\\.[ch]pp$")
list(SORT sources)
set(sums "")
foreach(source ${sources})
  file(SHA256 ${ROOT}/${source} sum)
  string(APPEND sums "${sum}  ${source}\n")
endforeach()
string(SHA256 sum "${sums}")
string(SUBSTRING ${sum} 0 16 sum)
file(WRITE ${OUTPUT} "#pragma once

namespace dwell::record {
// The beginning of the SHA-256 over all sources of the programs (sources.cmake).
inline constexpr const char* kSources = \"${sum}\";
}  // namespace dwell::record
")
