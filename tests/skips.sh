# For scripts to source: reports skipped tests, as tests/skips/mod.rs does for Rust.

# skipped MISSING UNTESTED: reports a skipped test, and records it for the summary of tests/all.sh.
skipped() {
    echo "skipped for want of $1: $2" >&2
    [ -z "${ONEIRO_SKIPPED:-}" ] || echo "$1: $2 (${0##*/})" >>"$ONEIRO_SKIPPED"
}

# skip_summary: lists tests skipped since ONEIRO_SKIPPED was emptied. Fails unless ONEIRO_MAY_SKIP, a comma-separated
# list of words, names everything that was missing.
skip_summary() {
    local missing code=0
    if [ ! -s "$ONEIRO_SKIPPED" ]; then
        echo "nothing was skipped"
        return
    fi
    sort -u "$ONEIRO_SKIPPED"
    for missing in $(cut -d: -f1 "$ONEIRO_SKIPPED" | sort -u); do
        case ,${ONEIRO_MAY_SKIP:-}, in
        *",$missing,"*) ;;
        *)
            echo "$missing is missing, and ONEIRO_MAY_SKIP does not name it" >&2
            code=1
            ;;
        esac
    done
    return $code
}
