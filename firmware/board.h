/* What the main loop needs of a robot. For a robot of yours, write these four functions. */

#ifndef BOARD_H
#define BOARD_H

/* Once, when the robot is switched on. */
void board_begin(void);

/* What the controller's check returned: 0 if it has the simulator's bits on this processor. */
void board_checked(int differing);

/* Waits for the next cycle of 100 ms, and reads the sensors in the order and the units of the controller's file. Returns whether all could
   be read. */
int board_read(float *inputs, int count);

/* Drives the wheels at these fractions of full speed, -1 to 1; `outputs` are the controller's commands, 0 to 1. */
void board_drive(const float *outputs, const float *speeds);

#endif
