# Runs steps, two at a time, each with a time limit and a log of its own, and shows how far they are.
# Sourced by ./check. A step is a row of STEPS (steps.sh) and the function of the same name there.

LOGS=build/logs
PASSED=0
FAILED=0
declare -A STATE=() # step -> running, ok, failed
declare -A STARTED=() PID_OF=()

field() { # field STEP N: column N of the step's row
  local row
  for row in "${STEPS[@]}"; do
    if [[ ${row%%|*} == "$1" ]]; then
      echo "$row" | cut -d'|' -f"$2"
      return
    fi
  done
}

clock() { printf '%d:%02d' $(($1 / 60)) $(($1 % 60)); }

# How far a running step is: ninja's last [done/all], or the ctest line, or nothing.
percent() {
  local at
  at=$(tail -c 2000 "$LOGS/$1.log" 2>/dev/null | grep -aoE '^\[[0-9]+/[0-9]+\]|^ *[0-9]+/[0-9]+ Test' | tail -n 1 |
    grep -oE '[0-9]+/[0-9]+')
  [[ -n $at ]] && echo "$((100 * ${at%/*} / ${at#*/}))%"
}

draw() {
  $TTY || return 0
  local marks='|/-\' step line=""
  TURN=$(((${TURN:-0} + 1) % 4))
  for step in "${ORDER[@]}"; do
    if [[ ${STATE[$step]:-} == running ]]; then
      line+="  $step $(percent "$step") $(clock $((SECONDS - STARTED[$step])))"
    fi
  done
  printf '\r\033[K%s [%d/%d]%s' "${marks:$TURN:1}" "$DONE" "${#ORDER[@]}" "$line"
}
wipe() { if $TTY; then printf '\r\033[K'; fi; }

launch() {
  local step=$1
  STATE[$step]=running
  STARTED[$step]=$SECONDS
  timeout -k 10 "$(field "$step" 3)" bash .ci/steps.sh "$step" >"$LOGS/$step.log" 2>&1 </dev/null &
  PID_OF[$step]=$!
}

# Sums what ctest says in a log: "100% tests passed, 0 tests failed out of 12".
count_tests() {
  local failed all
  while read -r failed all; do
    PASSED=$((PASSED + all - failed))
    FAILED=$((FAILED + failed))
    TESTS=$((TESTS + all))
  done < <(sed -nE 's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+).*/\1 \2/p' "$LOGS/$1.log")
}

finish() { # finish STEP EXIT_CODE
  local step=$1 code=$2 seconds=$((SECONDS - STARTED[$1])) note="" TESTS=0
  DONE=$((DONE + 1))
  count_tests "$step"
  ((TESTS > 0)) && note="  ($TESTS tests)"
  wipe
  if ((code == 0)); then
    STATE[$step]=ok
    PASSED=$((PASSED + 1))
    printf 'ok      %6s  %-16s %s%s\n' "$(clock $seconds)" "$step" "$(field "$step" 5)" "$note"
    grep -a '^note: ' "$LOGS/$step.log" | sed 's/^/                /'
    return
  fi
  STATE[$step]=failed
  FAILED=$((FAILED + 1))
  printf 'FAILED  %6s  %-16s %s%s\n' "$(clock $seconds)" "$step" "$(field "$step" 5)" "$note"
  ((code == 124 || code == 137)) && echo "  ran past its limit of $(field "$step" 3) s and was ended"
  { grep -aE 'error:|CMake Error|FAILED|\*\*\*Failed|\(Failed\)|\*\*\*Timeout' "$LOGS/$step.log" | head -n 12; echo "..."
    tail -n 12 "$LOGS/$step.log"; } | cut -c1-600 | sed 's/^/  | /'
  echo "  whole log: $LOGS/$step.log     again, alone: ./check --only $step"
}

# ready STEP: its predecessor, if it is part of this run, has ended. Whether that one passed does not matter: a step
# that finds nothing to work on says so itself.
ready() {
  local before
  for before in $(field "$1" 4); do
    case " ${ORDER[*]} " in
      *" $before "*) [[ ${STATE[$before]:-} == ok || ${STATE[$before]:-} == failed ]] || return 1 ;;
    esac
  done
}

stop_all() {
  local step
  wipe
  for step in "${!PID_OF[@]}"; do
    [[ ${STATE[$step]} == running ]] && kill -TERM "${PID_OF[$step]}" 2>/dev/null
  done
  echo "interrupted"
  exit 130
}

# run_steps STEP...: the rows' order is the order of start.
run_steps() {
  ORDER=("$@")
  DONE=0
  mkdir -p "$LOGS"
  trap stop_all INT TERM
  local step running
  while ((DONE < ${#ORDER[@]})); do
    running=0
    for step in "${ORDER[@]}"; do
      [[ ${STATE[$step]:-} == running ]] || continue
      if kill -0 "${PID_OF[$step]}" 2>/dev/null; then
        running=$((running + 1))
      else
        wait "${PID_OF[$step]}"
        finish "$step" $?
      fi
    done
    for step in "${ORDER[@]}"; do
      ((running < LANES)) || break
      if [[ -z ${STATE[$step]:-} ]] && ready "$step"; then
        launch "$step"
        running=$((running + 1))
      fi
    done
    draw
    sleep 0.2
  done
  wipe
}
