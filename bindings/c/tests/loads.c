/* Three loads of 900 kg into a truck that shall hold 2500 kg. */
#include <math.h>
#include <stdio.h>

#include "heft.h"

static uint64_t memory[HEFT_SIZE_MAX / 8];

#define CHECK(what)                                                                                \
    if (!(what)) {                                                                                 \
        fprintf(stderr, "line %d: %s\n", __LINE__, #what);                                         \
        return 1;                                                                                  \
    }

/* Ten loads of 900 kg: the sum's deviation over what ten loads would have that share no error. */
static double shared(int32_t initialised)
{
    heft_loads_row row = {0.0, 0.0, 60.0, NAN, NAN, 1, 0, 0, HEFT_LOADS_WITNESS_MOTION};
    heft_loads loads;
    int i;

    if (initialised != HEFT_OK)
        return -1.0;
    for (i = 0; i < 10000; i++) {
        row.t = 0.01 * i;
        row.payload = i % 1000 > 200 && i % 1000 < 600 ? 920.0 : 20.0;
        if (heft_loads_step(memory, &row, &loads) != HEFT_OK)
            return -1.0;
    }
    return loads.truck_loads == 10 ? loads.truck_mass_std / (sqrt(10.0) * loads.delivered_std) : -1.0;
}

/* What all loads of a machine are off together does not average out. */
static int machines(void)
{
    heft_excavator_settings excavator;
    heft_loader_settings loader;
    double alone;

    heft_excavator_defaults(&excavator);
    heft_loader_defaults(&loader);
    excavator.machine.operating_mass = 20000.0;
    CHECK(heft_excavator_complete(&excavator) == HEFT_OK);
    alone = shared(heft_loads_init(memory, sizeof memory, 1000.0, NAN, 0.0));
    CHECK(alone > 1.0 && alone < 2.8);
    CHECK(shared(heft_excavator_loads_init(memory, sizeof memory, &excavator, NAN, 0.0)) > 3.0);
    CHECK(shared(heft_excavator_loads_init(memory, sizeof memory, NULL, NAN, 0.0)) > 0.0);
    CHECK(fabs(shared(heft_loader_loads_init(memory, sizeof memory, &loader, NAN, 0.0)) - alone) < 0.1);
    CHECK(heft_excavator_loads_init(NULL, sizeof memory, &excavator, NAN, NAN) == HEFT_NULL);
    CHECK(heft_excavator_loads_init(memory, 8, &excavator, NAN, NAN) == HEFT_MEMORY);
    CHECK(heft_excavator_loads_init(memory, sizeof memory, &excavator, -1.0, NAN) == HEFT_REFUSED);
    CHECK(heft_excavator_loads_init_as(memory, sizeof memory, &excavator, NAN, NAN, 1) == HEFT_OTHER_HEADER);
    excavator.geometry.boom_length = NAN;
    CHECK(heft_excavator_loads_init(memory, sizeof memory, &excavator, NAN, NAN) == HEFT_REFUSED);
    return 0;
}

int main(void)
{
    heft_loads_row row;
    heft_loads loads;
    int i;


    CHECK(heft_loads_size() <= sizeof memory);
    CHECK(heft_loads_step(memory, &row, &loads) == HEFT_NOT_INITIALISED);
    CHECK(heft_loads_init(memory, 8, 1000.0, NAN, NAN) == HEFT_MEMORY);
    CHECK(heft_loads_init(NULL, sizeof memory, 1000.0, NAN, NAN) == HEFT_NULL);
    CHECK(heft_loads_init(memory, sizeof memory, -1.0, NAN, NAN) == HEFT_REFUSED);
    CHECK(heft_loads_init(memory, sizeof memory, 1e160, NAN, NAN) == HEFT_REFUSED);
    CHECK(heft_loads_step(memory, &row, &loads) == HEFT_NOT_INITIALISED);
    CHECK(heft_loads_init(memory, sizeof memory, 1000.0, 2500.0, NAN) == HEFT_OK);
    CHECK(heft_loads_step(memory, NULL, &loads) == HEFT_NULL);
    row.speed = row.truck = NAN;
    row.trusted = 1;
    row.changing = row.reason = 0;
    row.witness = HEFT_LOADS_WITNESS_PRESSURE;
    for (i = 0; i < 3000; i++) {
        row.t = 0.01 * i;
        row.payload = i % 1000 > 200 && i % 1000 < 600 ? 920.0 : 20.0;
        row.payload_std = 15.0;
        CHECK(heft_loads_step(memory, &row, &loads) == HEFT_OK);
        CHECK(isfinite(loads.payload) && isfinite(loads.payload_std));
    }
    CHECK(loads.load == 3 && loads.truck == 1 && loads.truck_loads == 3);
    CHECK(fabs(loads.truck_mass - 2700.0) < 60.0);
    CHECK(fabs(loads.remaining + 200.0) < 60.0);
    CHECK(loads.flags & HEFT_LOADS_FLAG_FINAL && loads.flags & HEFT_LOADS_FLAG_TRUCK_TRUSTED);
    CHECK(loads.witness == HEFT_LOADS_WITNESS_PRESSURE);
    row.payload = NAN; /* nothing weighs it any more */
    for (; i < 3500; i++) {
        row.t = 0.01 * i;
        CHECK(heft_loads_step(memory, &row, &loads) == HEFT_OK);
    }
    CHECK(fabs(loads.payload - 20.0) < 15.0 && loads.payload_std > 100.0 && loads.payload_age > 4.9);
    CHECK(heft_loads_next_truck(memory, &loads) == HEFT_OK);
    CHECK(loads.truck == 2 && loads.truck_loads == 0);
    CHECK(fabs(loads.remaining - 2500.0) < 1e-9);
    CHECK(heft_loads_set_target(memory, 18000.0, &loads) == HEFT_OK);
    CHECK(loads.flags & HEFT_LOADS_FLAG_HAS_TARGET && fabs(loads.remaining - 18000.0) < 1e-9);
    CHECK(heft_loads_set_target(memory, -1.0, &loads) == HEFT_REFUSED);
    CHECK(heft_loads_set_target(memory, INFINITY, &loads) == HEFT_REFUSED);
    CHECK(heft_loads_next_truck(memory, &loads) == HEFT_OK);
    CHECK(fabs(loads.remaining - 18000.0) < 1e-9);
    CHECK(heft_loads_set_target(memory, NAN, &loads) == HEFT_OK);
    CHECK(!(loads.flags & HEFT_LOADS_FLAG_HAS_TARGET));
    CHECK(heft_loads_set_target(memory, 18000.0, NULL) == HEFT_NULL);
    CHECK(machines() == 0);
    return 0;
}
