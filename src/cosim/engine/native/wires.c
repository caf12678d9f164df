/* SPDX-License-Identifier: Apache-2.0
 *
 * What a wire hands on.
 */
RARE double looked_up(const Wire *wire, double value) {
    for (int64_t i = 0; i < wire->pairs; i++) {
        if (wire->table[2 * i] == value) return wire->table[2 * i + 1];
    }
    return value;
}

OFTEN double translated(const Wire *wire, double source) {
    const double value = source * wire->factor + wire->offset;
    return wire->pairs ? looked_up(wire, value) : value;
}

OFTEN double handed_on(const Wire *wire, const double *values) { return translated(wire, values[wire->source]); }
