# Power is cut at random instants while runs are recorded on ext4. Of the disk is left what a flush had made lasting, and of
# the writes that were under way none, any part or all. The disk takes 2 ms for a write and 20 ms for a flush.
. ./settings  # cuts, seed
sectors=$((96 * 2048))
after_a_cut() {  # CUT EXTRA: what of the writes under way has arrived
  cp --sparse=always "$work/first" "$work/left.img"
  power_cuts image "$work/log" "$1" $((seed * 1000 + $1)) "$2" "$work/left.img" || return
  mount -o loop "$work/left.img" "$work/left" || return
  power_cuts check "$work/cuts" "$1" "$work/left"
  local code=$?
  umount "$work/left"
  return $code
}
after_all() {  # EXTRA
  local cut code=0
  for cut in $(seq "$cuts"); do
    after_a_cut "$cut" "$1" >"$work/said" 2>&1 || { code=1; cat "$work/said"; }
    tail -n 1 "$work/said" >>"$work/losses"
  done
  return $code
}

mkdir -p "$work/recorded" "$work/left"
truncate -s $((sectors * 512)) "$work/disk"
truncate -s 512M "$work/log"
mkfs.ext4 -q -F -m 0 "$work/disk"
cp --sparse=always "$work/disk" "$work/first"
disk=$(losetup -f --show "$work/disk") log=$(losetup -f --show "$work/log")
dmsetup create slow --table "0 $sectors delay $disk 0 0 $disk 0 2 $disk 0 20"
dmsetup create power --table "0 $sectors log-writes /dev/mapper/slow $log"
mount /dev/mapper/power "$work/recorded"
power_cuts record "$work/recorded" power "$cuts" "$seed" >"$work/cuts" 2>"$work/disk-speed"
claim "power: runs are recorded, and cut $cuts times (seed $seed)" test "$(wc -l <"$work/cuts")" = "$cuts"
umount "$work/recorded"
dmsetup remove power
dmsetup remove slow
losetup -d "$disk" "$log"
for extra in none some all; do
  claim "power: all older than two seconds is left; of the writes under way, $extra" after_all $extra
done
cat "$work/disk-speed"
echo "the cut that cost most: $(sort -t, -k2 "$work/losses" | tail -n 1)"
