#include <utility>

#include "config/draft.hpp"

namespace dwell::config {

void read_modbus_server(Section& section, Draft& draft) {
  constexpr const char* kModbusListen =
      "\"ADDRESS:PORT\" with a numeric address or localhost, for instance \"127.0.0.1:1502\"";
  std::string listen;
  if (section.text("listen", listen, kModbusListen, Need::required)) {
    if (auto address = split_address(listen))
      draft.file.modbus_server = {std::move(*address), false, section.where("listen")};
    else
      section.wrong("listen", "\"listen\" is " + in_quotes(listen) + ": expected " + kModbusListen);
  }
  bool open_to_network = false;
  section.boolean("open_to_network", open_to_network);
  if (draft.file.modbus_server) draft.file.modbus_server->open_to_network = open_to_network;
  section.refuse_rest();
}

}  // namespace dwell::config
