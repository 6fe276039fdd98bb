#include <utility>

#include "config/draft.hpp"

namespace dwell::config {

void read_modbus_server(Section& section, Draft& draft) {
  constexpr const char* kModbusListen =
      "\"ADDRESS:PORT\" with a numeric address or localhost, for instance \"127.0.0.1:1502\"";
  auto address = read_listen(section, kModbusListen, Need::required);
  bool open_to_network = false;
  section.boolean("open_to_network", open_to_network);
  if (address) draft.file.modbus_server = {std::move(*address), open_to_network, section.where("listen")};
  section.refuse_rest();
}

}  // namespace dwell::config
