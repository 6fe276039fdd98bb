// The key of a person's own, by which dwellctl signs what that person makes.
#pragma once

#include <string>

#include "daemon/record/keys.hpp"

namespace dwell::ctl {

// $XDG_CONFIG_HOME/dwell/key, or ~/.config/dwell/key. Fails where neither is known.
[[nodiscard]] record::Result<std::string> personal_key_path();

// USER@HOST, what a new one is called.
[[nodiscard]] std::string personal_key_name();
// Writes the key to a new file, in a folder that others cannot read if that is new, and its public part to PATH.pub.
[[nodiscard]] record::Result<void> save_personal_key(const record::SigningKey& key, const std::string& path);

struct PersonalKey {
  record::SigningKey key;
  bool made = false;  // just now
};

// The key in the file at `path`; where there is none, a new one, saved there.
[[nodiscard]] record::Result<PersonalKey> load_or_make_key(const std::string& path);

}  // namespace dwell::ctl
