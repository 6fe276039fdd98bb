#include <utility>

#include "config/draft.hpp"

namespace dwell::config {

void read_modbus_server(Section& section, Draft& draft) {
  constexpr const char* kModbusListen =
      "\"ADDRESS:PORT\" with a numeric address or localhost, for instance \"127.0.0.1:1502\"";
  if (auto address = read_listen(section, kModbusListen, Need::required))
    draft.file.modbus_server = {std::move(*address), false, section.where("listen")};
  bool open_to_network = false;
  section.boolean("open_to_network", open_to_network);
  if (draft.file.modbus_server) draft.file.modbus_server->open_to_network = open_to_network;
  section.refuse_rest();
}

}  // namespace dwell::config
