# A chain of 64 masses, whose element k has c = 1000 k, r = 10 k and a hundredth of it as U95, read by pymodbus. c of
# element 12 violates its limit, r of it is undecided:
# read_registers.py PORT
import struct
import sys

from pymodbus.client import ModbusTcpClient

client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]), timeout=20)
assert client.connect()


def float32(registers, at):
    return struct.unpack(">f", struct.pack(">HH", *registers[at:at + 2]))[0]


for page in range(7):
    answer = client.read_input_registers(200 * page, 125, slave=1)
    assert not answer.isError(), answer
    registers = answer.registers
    assert registers == client.read_holding_registers(200 * page, 125, slave=255).registers, "both tables are one"
    assert registers[0] == registers[124] == 1, "the generation"
    assert registers[1] == 3 and registers[3] == 2 and registers[6] == 1 and registers[7] == 65, registers[:24]
    assert registers[23] == (0xc002 if page == 1 else 0xc000), hex(registers[23])
    behind = client.read_input_registers(200 * page + 124, 5, slave=1).registers
    assert behind == [registers[0], *([2, 0, 0, 2] if page == 1 else [0, 0, 0, 0])], (page, behind)
    for i in range(10):
        k, at = 10 * page + i + 1, 24 + 10 * i
        numbers = [float32(registers, at + 2 * j) for j in range(1, 5)]
        if k <= 65:
            assert registers[at:at + 2] == [1, k], (k, registers[at:at + 2])
            expected = [1000 * k, 10 * k, 10 * k, 0.1 * k]
            assert all(abs(n - e) < 1e-6 * e for n, e in zip(numbers, expected)), (k, numbers)
        else:
            assert registers[at:at + 2] == [0, 0] and all(n != n for n in numbers), (k, numbers)
for answer, code in [(client.read_input_registers(129, 1), 2), (client.read_input_registers(1400, 1), 2),
                     (client.write_register(0, 1), 1), (client.write_registers(0, [1, 2]), 1),
                     (client.read_coils(0, 1), 1)]:
    assert answer.isError() and answer.exception_code == code, answer
