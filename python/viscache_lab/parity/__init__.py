"""Does a scene come out right? Pictures of viscache and of Mitsuba 3, block by block."""
