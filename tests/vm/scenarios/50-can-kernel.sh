# The driver contract and the socket seam on the kernel's own CAN, the wall clock being set meanwhile.
passes() {  # FILTER
  DWELL_DRIVER_PATH=$(dirname "$(find /usr/lib -name dwell-driver-can.so)") DWELL_TEST_SETS_THE_CLOCK=1 \
    driver_tests --gtest_brief=1 --gtest_filter="$1" >"$work/tests" 2>&1 || { grep -E 'Failure|FAILED|error' "$work/tests"; return 1; }
  grep -E 'PASSED' "$work/tests" && ! grep -q 'SKIPPED' "$work/tests"
}

claim "can: the driver contract holds on a CAN interface" passes '*/VirtualCan'
for test in $(driver_tests --gtest_list_tests --gtest_filter='CanKernel.*' | sed -n 's/^  //p'); do
  claim "can: $test" passes "CanKernel.$test"
done
