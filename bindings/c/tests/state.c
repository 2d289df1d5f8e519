/* A saved state goes on bit for bit; what is damaged, of another machine or of another header is refused. */
#undef NDEBUG
#include <assert.h>
#include <math.h>
#include <string.h>

#include "heft.h"

static uint64_t memory[HEFT_SIZE_MAX / 8];
static uint64_t other[HEFT_SIZE_MAX / 8];
static char state[HEFT_SIZE_MAX + 64];

#define COLUMNS (HEFT_EXCAVATOR_COLUMN_SWING_VELOCITY | HEFT_EXCAVATOR_COLUMN_SWING_TORQUE)

static void step(uint64_t *where, int i, heft_excavator_estimate *estimate)
{
    heft_excavator_sample sample;
    assert(heft_excavator_clear(&sample) == HEFT_OK);
    assert(isnan(sample.boom_angle) && isnan(sample.truck) && isnan(sample.t));
    sample.t = 0.01 * i;
    sample.swing_velocity = 0.3 * sin(0.01 * i);
    sample.swing_torque = 3000.0 * cos(0.01 * i);
    assert(heft_excavator_step(where, &sample, estimate) == HEFT_OK);
}

int main(void)
{
    heft_excavator_estimate a, b;
    heft_loader_settings settings;
    const size_t size = heft_excavator_state_size();
    size_t at;
    int i;

    assert(heft_abi() == HEFT_ABI);
    assert(strcmp(heft_version(), HEFT_VERSION) == 0);
    assert(heft_excavator_clear(NULL) == HEFT_NULL);
    assert(size <= sizeof state && size > heft_excavator_size());
    /* Another header. */
    assert(heft_excavator_init_as(memory, sizeof memory, NULL, 0, COLUMNS, HEFT_ABI + 1) == HEFT_OTHER_HEADER);
    assert(heft_loads_init_as(memory, sizeof memory, 1000.0, NAN, NAN, HEFT_ABI + 1) == HEFT_OTHER_HEADER);
    /* A column that is no signal. */
    assert(heft_excavator_init(memory, sizeof memory, NULL, 0, 0xffffffffu) == HEFT_REFUSED);
    assert(strstr(heft_excavator_error(memory), "columns"));

    assert(heft_excavator_save(memory, state, size) == HEFT_NOT_INITIALISED);
    assert(heft_excavator_init(memory, sizeof memory, NULL, 0, COLUMNS) == HEFT_OK);
    for (i = 0; i < 500; i++)
        step(memory, i, &a);
    assert(heft_excavator_save(NULL, state, size) == HEFT_NULL);
    assert(heft_excavator_save(memory, state, size - 1) == HEFT_MEMORY);
    assert(heft_excavator_save(memory, state, size) == HEFT_OK);
    assert(heft_excavator_restore(other, heft_excavator_size() - 1, state, size) == HEFT_MEMORY);
    assert(heft_excavator_restore(other, sizeof other, state, size - 1) == HEFT_REFUSED);
    assert(heft_loader_restore(other, sizeof other, state, size) == HEFT_REFUSED);
    /* From an address of its own, not aligned. */
    memmove(state + 1, state, size);
    assert(heft_excavator_restore(other, sizeof other, state + 1, size) == HEFT_OK);
    for (i = 500; i < 1500; i++) {
        step(memory, i, &a);
        step(other, i, &b);
        assert(memcmp(&a, &b, sizeof a) == 0);
    }
    /* Each damaged byte is noticed, and the memory stays as it was. */
    for (at = 0; at < size; at += 97) {
        state[1 + at] = (char)(state[1 + at] ^ 4);
        assert(heft_excavator_restore(other, sizeof other, state + 1, size) == HEFT_REFUSED);
        state[1 + at] = (char)(state[1 + at] ^ 4);
    }
    step(memory, 1500, &a);
    step(other, 1500, &b);
    assert(memcmp(&a, &b, sizeof a) == 0);
    assert(heft_loader_defaults(&settings) == HEFT_OK);
    return 0;
}
