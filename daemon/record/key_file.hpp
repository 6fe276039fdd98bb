// The service's key in its recording directory: `key`, mode 0600, and its public part `key.pub`, the vkey in one line.
//
// A change of keys survives a crash at any instant: `key.next` is written first, then the ledger says so, signed by the
// old key, then `key.next` takes the place of `key`.
#pragma once

#include <string>

#include "daemon/record/keys.hpp"
#include "daemon/record/ledger.hpp"

namespace dwell::record {

// The file of the private key.
[[nodiscard]] std::string key_path(const std::string& directory);

// The key that signs here and the ledger it signs.
struct KeyAndLedger {
  SigningKey key;
  Ledger ledger;
  bool made = false;  // the key is new: this is the first start
};

// Makes a key with this name if there is none. Completes a change of keys that was cut off. Corrects `key.pub`.
[[nodiscard]] Result<KeyAndLedger> open_key_and_ledger(const std::string& directory, const std::string& name);

// Changes the key: a new one with this name signs from now on. The old private key's file is replaced; its bytes may
// remain on the disk. Fails while a service records here. The old vkey stays in the ledger and in the files that it
// signed.
[[nodiscard]] Result<PublicKey> change_key(const std::string& directory, const std::string& name);

}  // namespace dwell::record
