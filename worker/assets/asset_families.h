// The families' registration functions, which AssetCatalogue calls, and the makers of classes that
// another file than their own registers.
#pragma once

#include <vector>

#include "worker/assets/asset.h"

namespace parallax {

// Each function appends the classes of one family.
void RegisterWindows(std::vector<AssetClass>& classes);
void RegisterKitchens(std::vector<AssetClass>& classes);
void RegisterStairs(std::vector<AssetClass>& classes);
void RegisterDoors(std::vector<AssetClass>& classes);
void RegisterAppliances(std::vector<AssetClass>& classes);
void RegisterBathroom(std::vector<AssetClass>& classes);
void RegisterChairs(std::vector<AssetClass>& classes);
void RegisterSofas(std::vector<AssetClass>& classes);
void RegisterTables(std::vector<AssetClass>& classes);
void RegisterStorage(std::vector<AssetClass>& classes);
void RegisterBeds(std::vector<AssetClass>& classes);
void RegisterBooks(std::vector<AssetClass>& classes);
void RegisterTableware(std::vector<AssetClass>& classes);
void RegisterLamps(std::vector<AssetClass>& classes);
void RegisterPlants(std::vector<AssetClass>& classes);
void RegisterNature(std::vector<AssetClass>& classes);
void RegisterWall(std::vector<AssetClass>& classes);
void RegisterTextiles(std::vector<AssetClass>& classes);
void RegisterMisc(std::vector<AssetClass>& classes);

// Each draws the parameters of a class from the stream and makes it.
Asset SampleOven(Rng& rng);
Asset SampleBeverageFridge(Rng& rng);
Asset SampleTv(Rng& rng);
Asset SampleMonitor(Rng& rng);
Asset SampleSimpleBookcase(Rng& rng);
Asset SampleLargeShelf(Rng& rng);
Asset SampleCellShelf(Rng& rng);
Asset SampleTVStand(Rng& rng);
Asset SampleTriangleShelf(Rng& rng);
Asset SampleRack(Rng& rng);
Asset SampleBalloon(Rng& rng);
Asset SampleCan(Rng& rng);
Asset SampleFoodBox(Rng& rng);
Asset SampleFoodBag(Rng& rng);
Asset SampleVase(Rng& rng);
Asset SampleBottle(Rng& rng);
Asset SampleCup(Rng& rng);
Asset SampleBowl(Rng& rng);
Asset SamplePlate(Rng& rng);
Asset SamplePot(Rng& rng);
Asset SamplePan(Rng& rng);
Asset SampleJar(Rng& rng);
Asset SampleWineglass(Rng& rng);
Asset SampleLid(Rng& rng);
Asset SampleShirt(Rng& rng);
Asset SamplePants(Rng& rng);
Asset SampleFloorLamp(Rng& rng);
Asset SampleDeskLamp(Rng& rng);
Asset SamplePlantContainer(Rng& rng);
Asset SampleLargePlantContainer(Rng& rng);
Asset SampleBush(Rng& rng);
Asset SampleCactus(Rng& rng);
Asset SampleUrchin(Rng& rng);
Asset SampleMattress(Rng& rng);
Asset SamplePillow(Rng& rng);
Asset SampleBlanket(Rng& rng);
Asset SampleTowel(Rng& rng);
Asset SampleOfficeChair(Rng& rng);
Asset SampleBarChair(Rng& rng);
Asset SampleSimpleDesk(Rng& rng);
Asset SampleBathtub(Rng& rng);

}  // namespace parallax
