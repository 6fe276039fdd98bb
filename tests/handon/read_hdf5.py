# The HDF5 export against the samples that were recorded: read_hdf5.py EXPORT SAMPLES RESULTS
# Instants equal to 1 ns, values to the last bit. 77: h5py is not installed (Debian: python3-h5py).
import json
import sys

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

export, samples, results = sys.argv[1], sys.argv[2], int(sys.argv[3])
table = numpy.loadtxt(samples, dtype=numpy.int64)
with h5py.File(export, "r") as file:
    at = dict(file.attrs)
    assert at["run"] == 7 and at["id"] == "00112233445566778899aabbccddeeff", at
    assert at["label"] == 'cold <b>start</b> & "quoted"' and at["rig"] == "mount <1>" and at["operator"] == "o'brien", at
    assert at["head"] == "ab12" and at["audit"] == "intact, key none", at
    assert at["zero_ns"] == 4_000_000_000_123 and at["start_utc"] == "2026-11-23T03:12:17.250000Z", at
    assert "[[channel]]" in file["rig_file"][()].decode()
    groups = file["channels"]
    assert set(groups) == {"y0", "reaction", "oil_temp °C"}, list(groups)
    for number, name in enumerate(["y0", "reaction", "oil_temp °C"]):
        group, rows = groups[name], table[table[:, 0] == number]
        assert group["t_ns"].dtype == numpy.int64 and group["value"].dtype == numpy.float64
        numpy.testing.assert_array_equal(group["t_ns"][:], rows[:, 1])
        raw = rows[:, 2].view(numpy.float64)
        assert group["raw"][:].tobytes() == raw.tobytes()
        value = group.attrs["scale"] * raw + group.attrs["offset"]
        assert group["value"][:].tobytes() == value.tobytes()
        numpy.testing.assert_array_equal(group["flags"][:], rows[:, 3])
        numpy.testing.assert_array_equal(group["t_half_ns"][:], rows[:, 4])
        assert group["t_ns"].attrs["unit"] == "ns" and group["value"].attrs["unit"] == group.attrs["unit"]
        assert group["t_ns"].maxshape == (None,) and group["t_ns"].chunks is not None
    y0 = groups["y0"].attrs
    assert (y0["unit"], y0["measures"], y0["at"]) == ("mm", "displacement", "the table"), dict(y0)
    assert (y0["calibration_id"], y0["calibration_due"], y0["si_per_unit"]) == ("K-2231", "2027-03-31", 1e-3), dict(y0)
    for absent in ("calibration_id", "calibration_due", "relative_to"):
        assert absent not in groups["oil_temp °C"].attrs, "the rig file does not state it"
    assert groups["oil_temp °C"].attrs["name"] == "oil/temp °C"
    assert len(file["results"]) == results
    for text in file["results"]:
        assert json.loads(text)["elements"][0]["stiffness"]["unit"] == "N/m"
    assert [json.loads(text)["text"] for text in file["events"]] == ["drive recognized"]
