// From when on numbers count as old, for the service and for dwellctl watch; the page is told them in /api/v1/health.
#pragma once

namespace dwell {

// Not renewed for so long, s. The service tells the whole dwell once a second, so one late message is no alarm and two
// missing ones are. Halved: a busy network makes numbers flicker grey. Doubled: an operator looks at dead numbers for
// five seconds.
inline constexpr double kOldAfter_s = 2.5;
// … or for so many of the times that usually lie between two renewals, where these are further apart: a rig may be read
// once in some seconds.
inline constexpr double kOldAfterUpdates = 2.5;

}  // namespace dwell
