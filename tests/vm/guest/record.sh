# What the scenarios of recording share: a folder on an ext4 of its own, a rig on CAN that is recorded, an operator.
folder=/var/lib/dwell

make_folder() {
  truncate -s 400M "$work/disk"
  mkfs.ext4 -q -F -m 0 "$work/disk"
  mkdir -p $folder
  mount -o loop "$work/disk" $folder
}
# The rig stands; the kernel believes its clock to be right within 1.5 ms.
start_recorded_rig() {
  make_folder
  id anna >/dev/null 2>&1 || useradd -G dwell anna
  clock-set synchronized 1500
  start_can vcan0
  start_rig --can vcan0 --can-rate 80 --noise 0.001 --stopped
  { can_rig vcan0 && printf '\n[recording]\n'; } | start_service
}
as_anna() { setpriv --reuid=anna --regid=anna --init-groups "$@"; }  # a member of the group dwell
run() { holds "$(dwellctl runs --json)" "any(.runs[]; .run == $1 and ($2))" || { dwellctl runs; return 1; }; }  # NUMBER EXPRESSION
file_of() { echo "$folder/$(dwellctl runs --json | jq -r ".runs[] | select(.run == $1) | .file")"; }        # NUMBER
shown() { holds "$(dwellctl show "$1" --json)" "$2" || { dwellctl show "$1"; return 1; }; }                 # FILE EXPRESSION
audit() { dwellctl audit "$@" --key $folder/key.pub --ledger $folder/ledger.dwell-ledger; }

owner_is() { [ "$(stat -c '%U:%G %a' "$1")" = "$2" ] || { stat -c '%n %U:%G %a' "$1"; return 1; }; }
may_not() { if "$@"; then return 1; fi; }
says_times() {  # COUNT EXPRESSION COMMAND…: so many lines of what the command prints; it succeeds
  local said
  said=$("${@:3}" 2>&1) && [ "$(grep -cE -- "$2" <<<"$said")" = "$1" ] || { echo "$said"; return 1; }
}
says() { says_times 1 "$@"; }
refused() {  # EXPRESSION COMMAND…: it says so and answers no
  local said code=0
  said=$("${@:2}" 2>&1) || code=$?
  [ "$code" = 1 ] && grep -qE -- "$1" <<<"$said" || { echo "$code: $said"; return 1; }
}
flip() {  # FILE OFFSET: its lowest bit
  local byte
  byte=$(od -An -tu1 -j "$2" -N 1 "$1")
  printf "\\x$(printf %02x $((byte ^ 1)))" | dd of="$1" bs=1 seek="$2" conv=notrunc status=none
}
