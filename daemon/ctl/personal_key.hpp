// A person's own key. dwellctl signs with it what that person makes.
#pragma once

#include <string>

#include "daemon/record/keys.hpp"

namespace dwell::ctl {

// $XDG_CONFIG_HOME/dwell/key, or ~/.config/dwell/key. Fails where neither is known.
[[nodiscard]] record::Result<std::string> personal_key_path();

// The name of a new key: USER@HOST.
[[nodiscard]] std::string personal_key_name();
// Writes the key to a new file, and its public part to PATH.pub, new as well. If either exists, fails and writes
// nothing. If the folder is new, others cannot read it.
[[nodiscard]] record::Result<void> save_personal_key(const record::SigningKey& key, const std::string& path);

struct PersonalKey {
  record::SigningKey key;
  bool made = false;  // it is new
};

// The key in the file at `path`. If there is no file, makes a new key and saves it there.
[[nodiscard]] record::Result<PersonalKey> load_or_make_key(const std::string& path);

}  // namespace dwell::ctl
