#include "config/draft.hpp"

namespace dwell::config {

void read_modbus_server(Section& section, Draft& draft) {
  constexpr const char* kModbusListen =
      "\"ADDRESS:PORT\" with a numeric address or localhost, for instance \"127.0.0.1:1502\"";
  std::string listen;
  if (section.text("listen", listen, kModbusListen, Need::required)) {
    draft.file.modbus_server = split_address(listen);
    if (!draft.file.modbus_server)
      section.wrong("listen", "\"listen\" is " + in_quotes(listen) + ": expected " + kModbusListen);
  }
  section.refuse_rest();
}

}  // namespace dwell::config
