// What becomes of the light that eye paths find: two exchangeable files with the same functions.
#if learns
#import lib/deliver_records
#else
#import lib/deliver_film
#endif
