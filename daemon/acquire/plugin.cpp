#include "daemon/acquire/plugin.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <system_error>

#include "config/driver_table.hpp"

namespace dwell::acquire {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "dwell-driver-";
constexpr std::string_view kSuffix = ".so";

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// What is wrong with a table; empty: nothing.
std::string fault_of(const dwell_driver_table* table, const std::string& name) {
  if (table == nullptr) return "it returns no table";
  if (table->abi != DWELL_DRIVER_ABI)
    return "it is made for version " + std::to_string(table->abi) + " of the driver interface, this is version " +
           std::to_string(DWELL_DRIVER_ABI);
  // The first header ended with these; what came later may be missing.
  constexpr std::size_t kFirstTable = offsetof(dwell_driver_table, describe);
  constexpr std::size_t kFirstKey = offsetof(dwell_key, help) + sizeof(dwell_key::help);
  if (table->size < kFirstTable) return "its table is too short, " + std::to_string(table->size) + " bytes";
  if (table->name == nullptr || name != table->name)
    return std::string("it calls itself `") + (table->name == nullptr ? "" : table->name) + "`";
  if (table->version == nullptr || table->help == nullptr) return "it has no version or no help text";
  if (table->key_count > 0 && table->keys == nullptr) return "its key schema is missing";
  if (table->key_count > 0 && (table->key_size < kFirstKey || table->key_size % alignof(dwell_key) != 0))
    return "its keys cannot be of " + std::to_string(table->key_size) + " bytes each";
  const std::vector<dwell_key> keys = config::keys_of(*table);
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i].name == nullptr || keys[i].unit == nullptr || keys[i].help == nullptr)
      return "its key " + std::to_string(i) + " has no name, unit or help text";
  if (table->check == nullptr || table->probe == nullptr || table->create == nullptr || table->start == nullptr ||
      table->stop == nullptr || table->destroy == nullptr)
    return "a function is missing in its table";
  return {};
}

tl::expected<const dwell_driver_table*, std::string> open_plugin(const fs::path& file, const std::string& name) {
  const auto refused = [&](const std::string& why) {
    return tl::make_unexpected("driver `" + name + "`: " + file.string() + " cannot be used: " + why);
  };
  // The handle is kept on purpose: threads, tables and texts of a plugin may be in use until the program ends.
  void* const handle = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (handle == nullptr) {
    const char* const why = ::dlerror();
    return refused(why == nullptr ? "unknown error of the dynamic linker" : why);
  }
  const auto entry = reinterpret_cast<dwell_driver_function>(::dlsym(handle, DWELL_DRIVER_SYMBOL));
  if (entry == nullptr) return refused("it does not export " DWELL_DRIVER_SYMBOL "()");
  const dwell_driver_table* const table = entry();
  const std::string fault = fault_of(table, name);
  if (!fault.empty()) return refused(fault);
  return table;
}

}  // namespace

std::vector<std::string> plugin_folders(const std::vector<std::string>& given) {
  std::vector<std::string> folders;
  const auto add = [&](std::string folder) {
    // An empty folder would mean the working directory, which is nobody's decision.
    if (!folder.empty() && std::find(folders.begin(), folders.end(), folder) == folders.end())
      folders.push_back(std::move(folder));
  };
  for (const std::string& folder : given) add(folder);
  if (const char* const path = ::secure_getenv("DWELL_DRIVER_PATH"); path != nullptr) {
    std::string_view rest = path;
    while (!rest.empty()) {
      const std::size_t colon = rest.find(':');
      add(std::string(rest.substr(0, colon)));
      rest.remove_prefix(colon == std::string_view::npos ? rest.size() : colon + 1);
    }
  }
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return folders;
  add(program.parent_path().string());
  add((program.parent_path() / DWELL_PLUGIN_DIR).lexically_normal().string());
  return folders;
}

tl::expected<const dwell_driver_table*, std::string> load_plugin(const std::string& name,
                                                                 const std::vector<std::string>& given) {
  const std::vector<std::string> folders = plugin_folders(given);
  if (config::is_driver_name(name)) {
    const std::string file = std::string(kPrefix) + name + std::string(kSuffix);
    for (const std::string& folder : folders) {
      std::error_code error;
      const fs::path path = fs::path(folder) / file;
      if (fs::exists(path, error)) return open_plugin(fs::absolute(path, error), name);
    }
  }
  const std::vector<std::string> names = plugin_names(given);
  std::string message = config::is_driver_name(name) ? "driver `" + name + "` does not exist in " + joined(folders)
                                                     : "a driver's name has only a-z, 0-9, _ and - in it";
  message += names.empty() ? "; there is no driver at all" : "; there are " + joined(names);
  return tl::make_unexpected(message);
}

std::vector<std::string> plugin_names(const std::vector<std::string>& given) {
  std::set<std::string> names;
  for (const std::string& folder : plugin_folders(given)) {
    std::error_code error;
    for (fs::directory_iterator place(folder, error), end; !error && place != end; place.increment(error)) {
      const std::string file = place->path().filename().string();
      if (file.size() <= kPrefix.size() + kSuffix.size() || file.compare(0, kPrefix.size(), kPrefix) != 0 ||
          file.compare(file.size() - kSuffix.size(), kSuffix.size(), kSuffix) != 0)
        continue;
      const std::string name = file.substr(kPrefix.size(), file.size() - kPrefix.size() - kSuffix.size());
      if (config::is_driver_name(name)) names.insert(name);
    }
  }
  return {names.begin(), names.end()};
}

}  // namespace dwell::acquire
