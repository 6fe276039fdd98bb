# The driver contract with a CANopen node on the kernel's own CAN.
passes() {  # FILTER
  DWELL_DRIVER_PATH=$(dirname "$(find /usr/lib -name dwell-driver-canopen.so)") \
    driver_tests --gtest_brief=1 --gtest_filter="$1" >"$work/tests" 2>&1 || { grep -E 'Failure|FAILED|error' "$work/tests"; return 1; }
  grep -E 'PASSED' "$work/tests" && ! grep -q 'SKIPPED' "$work/tests"
}

claim "canopen: the driver contract holds on a CAN interface" passes '*/VirtualCanopen'
