/* What a caller can do wrong is answered by a code, and nothing else happens. */
#undef NDEBUG
#include <assert.h>
#include <math.h>
#include <string.h>

#include "../include/heft.h"

static uint64_t memory[HEFT_SIZE_MAX / 8];

int main(void)
{
    heft_loader_settings settings;
    heft_loader_sample sample;
    heft_loader_estimate estimate;
    heft_excavator_sample other_sample;
    heft_excavator_estimate other;
    const uint32_t columns = 0x3f;
    double *numbers = (double *)&sample;
    size_t i;

    memset(memory, 0xa5, sizeof memory);
    memset(&other_sample, 0, sizeof other_sample);
    assert(heft_loader_defaults(NULL) == HEFT_NULL);
    assert(heft_loader_defaults(&settings) == HEFT_OK);
    assert(settings.machine.mass == 4700.0);
    assert(heft_loader_set(&settings, "machine.mass", 5000.0) == HEFT_OK);
    assert(settings.machine.mass == 5000.0);
    /* A value that no key takes changes nothing. */
    assert(heft_loader_set(&settings, "machine.mass", NAN) == HEFT_REFUSED);
    assert(heft_loader_set(&settings, "machine.mass", INFINITY) == HEFT_REFUSED);
    assert(heft_loader_set(&settings, "machine.mass", -1.0) == HEFT_REFUSED);
    assert(settings.machine.mass == 5000.0);
    assert(heft_loader_set(&settings, "machine.weight", 1.0) == HEFT_NO_SUCH_KEY);
    assert(heft_loader_complete(NULL) == HEFT_NULL);
    settings.machine.mass = NAN;
    assert(heft_loader_complete(&settings) == HEFT_REFUSED);
    /* Values that are not stated follow from the mass, and stated ones are unchanged. */
    settings.machine.mass = 20000.0;
    settings.machine.wheelbase = 3.5;
    assert(heft_loader_complete(&settings) == HEFT_OK);
    assert(settings.machine.mass == 20000.0 && settings.machine.wheelbase == 3.5);
    assert(settings.machine.wheel_radius > 0.7 && settings.prior.cg_height > 1.2);
    assert(heft_loader_defaults(&settings) == HEFT_OK);
    settings.machine.mass = 5000.0;
    assert(heft_loader_set(&settings, "machine.mass.", 1.0) == HEFT_NO_SUCH_KEY);

    /* Before init, or with memory that cannot serve. */
    assert(heft_loader_step(memory, &sample, &estimate) == HEFT_NOT_INITIALISED);
    assert(heft_loader_init(NULL, sizeof memory, &settings, 0, columns) == HEFT_NULL);
    assert(heft_loader_init(memory, heft_loader_size() - 1, &settings, 0, columns) == HEFT_MEMORY);
    assert(heft_loader_init((char *)memory + 1, sizeof memory - 1, &settings, 0, columns) == HEFT_MEMORY);

    /* Settings, method and columns that cannot be used are named. */
    assert(heft_loader_init(memory, sizeof memory, &settings, 99, columns) == HEFT_REFUSED);
    assert(strstr(heft_loader_error(memory), "method"));
    assert(heft_loader_init(memory, sizeof memory, &settings, 0, columns & ~1u) == HEFT_REFUSED);
    assert(strstr(heft_loader_error(memory), "speed"));
    settings.machine.mass = NAN;
    assert(heft_loader_init(memory, sizeof memory, &settings, 0, columns) == HEFT_REFUSED);
    assert(strstr(heft_loader_error(memory), "machine.mass"));
    settings.machine.mass = 1e308;
    assert(heft_loader_init(memory, sizeof memory, &settings, 0, columns) == HEFT_REFUSED);
    assert(strstr(heft_loader_error(memory), "machine.mass cannot be 1e308, but 0.001 to 1000000.0"));
    assert(heft_loader_step(memory, &sample, &estimate) == HEFT_NOT_INITIALISED);

    /* Another machine's memory. */
    assert(heft_loader_init(memory, sizeof memory, NULL, 0, columns) == HEFT_OK);
    assert(heft_loader_error(memory)[0] == '\0');
    assert(heft_excavator_step(memory, &other_sample, &other) == HEFT_NOT_INITIALISED);
    assert(heft_loader_step(memory, NULL, &estimate) == HEFT_NULL);
    assert(heft_loader_step(memory, &sample, NULL) == HEFT_NULL);

    /* Rows without anything, and of impossible numbers: answered, finite, not trusted. */
    for (i = 0; i < 300; i++) {
        const double bad[] = {NAN, INFINITY, -INFINITY, 1e308, 0.0};
        size_t k;
        for (k = 0; k < sizeof sample / sizeof(double); k++)
            numbers[k] = bad[(i + k) % 5];
        sample.t = 0.01 * (double)i;
        assert(heft_loader_step(memory, &sample, &estimate) == HEFT_OK);
        for (k = 0; k < offsetof(heft_loader_estimate, refused) / sizeof(double); k++)
            assert(isfinite(((double *)&estimate)[k]));
        assert(!(estimate.flags & HEFT_LOADER_FLAG_TRUSTED_HEIGHT));
    }
    /* A time that stands still is refused. */
    assert(heft_loader_step(memory, &sample, &estimate) == HEFT_OK);
    assert(estimate.flags & HEFT_LOADER_FLAG_REFUSED && estimate.refused == 1);
    return 0;
}
